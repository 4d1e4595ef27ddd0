"""Any simulator that makes a whole trial from commands, through the same interface.

Called for ``--sim mujoco``. Takes the rollout as a function; knows no MuJoCo itself.
"""
