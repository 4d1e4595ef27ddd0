"""Spring support: height, slopes and loads at which the leg springs carry the body (sec:contact).

Called by ``model.quasistatic`` and by fits of the stiffness. Knows nothing of friction.
"""
