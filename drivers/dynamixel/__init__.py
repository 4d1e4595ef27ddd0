"""The servo bus: Dynamixel protocol 2.0, from bytes to the bus of one robot.

Called by the rig and by bring-up. Knows one port and the servos on it; nothing of legs beyond their names.
"""
