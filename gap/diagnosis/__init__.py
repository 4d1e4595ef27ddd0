"""The diagnosis in its order, from trials to a verdict; ``diagnose`` is the way in.

Called by commands and campaigns. Knows the engine's rooms, no machine.
"""
