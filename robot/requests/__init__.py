"""The request of each command: its help, its options, and the function that does the work.

Called by ``robot.cli``, which makes the parsers of it, and by the packages that do the work. The class is
the command: ``bigant servo zero`` is ``robot.requests.servo.ServoZeroRequest``. Imports nothing heavy.
"""
