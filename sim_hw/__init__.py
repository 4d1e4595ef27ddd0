"""Virtual hardware: a plant, and virtual devices that speak the real bytes in front of it.

Called by ``robot.virtual`` and by tests. Does not know the model that it is there to test.
"""
