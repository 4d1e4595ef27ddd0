"""Motion in the plane and in time: SE(2), dead reckoning, rates and filters of sampled signals.

Called by everybody. Knows nothing of legs.
"""
