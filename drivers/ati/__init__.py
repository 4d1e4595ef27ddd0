"""The wireless force-torque unit of ATI: commands, console, stream, clock and repair.

Called by the rig and by bring-up. Knows transducers and counts; forces on feet are in ``foot_forces``.
"""
