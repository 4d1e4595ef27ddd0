"""MJCF and URDF as machines under diagnosis; and any simulator that makes a whole trial from commands.

Called by the engine through ``gap.interfaces``, for ``--machine robot.xml`` and for ``--sim mujoco``. Rigid
bodies and MuJoCo are known here alone in the diagnosis; ``simulator.py`` takes a rollout as a function.
"""
