"""Parameters from measured data: stiffness, friction, calibration of the force sensors in place.

Called by studies and bring-up, never by a tick. Knows no file: arrays come in, values with errors go out.
"""
