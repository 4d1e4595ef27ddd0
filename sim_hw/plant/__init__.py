"""The physical robot on the ground, in MuJoCo, with its own motors, linkage and friction.

Called by ``sim_hw.host``. Has parameters of its own and never calls the model.
"""
