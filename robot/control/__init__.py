"""The pure control step: sense, estimate, decide, command. The way in is ``controller``.

Called by the loop, by replays and by virtual runs. Knows no clock, socket, serial port, file, thread or
simulator.
"""
