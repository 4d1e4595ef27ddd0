"""The paper again: named systems, figures, parameters fitted to logs.

Called by ``bigant model``. Nothing that drives the robot needs it.
"""
