"""The whole model, support then traction, for one frame or many (the paper's steps A and B).

Called by the control step, the estimator, the diagnosis and the studies. Has no state and no time.
"""
