"""The force sensors: the unit by itself, readings as a table, poses at rest for calibration.

Called by ``bigant force``. Changes nothing in the unit but what a command names.
"""
