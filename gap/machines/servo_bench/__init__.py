"""Position-controlled servos, each on its own, as a machine under diagnosis.

Called by the engine through ``gap.interfaces``. Knows motor, gear and controller of one joint.
"""
