"""The report of a day: a row for each of its runs, and whether the robot differs from earlier runs.

Called by ``bigant report``. Computes no figure of its own: the summary of a log and the diagnosis do.
"""
