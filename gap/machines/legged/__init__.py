"""The legged robot: its catalogue, channels, checks, and its chain of stages as a simulator.

Called by the engine through ``gap.interfaces``. What effects do to the chain is ``model.effects``.
"""
