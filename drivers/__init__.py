"""The devices on the robot, and poses from outside.

Called by ``robot.run``, by bring-up, and by tests through virtual hardware. Knows nothing of gaits or the
model.
"""
