"""One rigid body sliding on level ground, as a machine under diagnosis.

Called by the engine through ``gap.interfaces``. Knows Coulomb friction of one body.
"""
