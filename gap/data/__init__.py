"""What trials show without any physics: faults of the data, clocks, even grids.

Called by machines and by the diagnosis before anything is blamed. Knows no effect.
"""
