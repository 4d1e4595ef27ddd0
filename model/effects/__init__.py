"""What an effect of the catalogue does to the chain of signals: commands, shafts, feet, forces, readings.

Called by the controller, one tick at a time, and by the diagnosis, a whole trial at a time. Knows no trial,
channel, log or device, and nothing of how causes are found.
"""
