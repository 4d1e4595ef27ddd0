"""The run that settles it: which experiment would separate the causes that remain.

Called by ``bigant gap next`` and at the end of a diagnosis. Runs nothing itself.
"""
