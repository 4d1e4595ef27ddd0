"""Gaits: shaft angle and speed of every leg at any time. Pure functions of time.

Called by the control step and by whoever plans a run. Knows no clock, socket, file or logger, and no
controller.
"""
