"""What held-out runs say of each cause: which are dropped, and which are named after all.

Called by ``diagnose`` when the search is done. Nothing here is fitted to the runs that judge.
"""
