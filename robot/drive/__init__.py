"""One run of the robot as a person asks for it: open, loop, log, and how it went. The way in is ``drive``.

Called by ``bigant drive`` and by replays that do a run again. Knows no option parser; loads nothing of the
simulator for a robot at real ports.
"""
