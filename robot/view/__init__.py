"""Watching a run, live or from its log: terminal, Foxglove, Rerun, ROS 2.

Called by ``drive``, ``view`` and ``bridge``. Reads ticks; nothing it does reaches the robot.
"""
