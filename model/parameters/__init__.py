"""What the software assumes about the robot, and how a robot file's tables become it.

Called by whoever reads a robot file. Knows no file: text comes in, frozen parameters go out.
"""
