"""Measured data of any machine as tables: read, mapped, checked, written.

Called by imports and by the diagnosis. Knows columns and units, nothing of a machine's physics.
"""
