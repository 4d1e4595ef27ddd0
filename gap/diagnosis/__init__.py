"""The diagnosis in its order, from trials to a verdict; call ``diagnose``.

Called by commands and campaigns. Knows the engine's packages, no machine. Its steps live in rooms:
``comparison`` (trials against the simulator), ``alternatives`` (which cause it is), ``held_out`` (what the
runs that judge say), ``answer`` (what is said of it).
"""
