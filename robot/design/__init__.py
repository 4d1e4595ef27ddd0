"""A robot file judged before anything moves: each gait walked through the model, and what is wrong with it.

Called by ``bigant robot show`` and ``new``, and by whatever drives a robot, for its warnings. Knows
kinematics and the quasi-static model only: no plant, no device.
"""
