"""Friction in the plane: body velocity and foot forces from feet and loads (sec:planar).

Called by ``model.quasistatic`` and by fits of the friction. Knows nothing of how the loads came about.
"""
