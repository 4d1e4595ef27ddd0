"""Joint angles to foot positions and their exact derivative.

Called by the control step, the estimator and the diagnosis. Knows nothing of forces.
"""
