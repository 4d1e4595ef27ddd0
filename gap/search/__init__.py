"""Which causes fit: candidates, signatures, fits, and whether one more cause is new.

Called by the diagnosis. Decides on held-out blocks; knows no verdict.
"""
