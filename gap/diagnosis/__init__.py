"""The diagnosis in its order, from trials to a verdict; call ``diagnose``.

Called by commands and campaigns. Knows the engine's packages, no machine.
"""
