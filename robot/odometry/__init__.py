"""Odometry from logs and during a run: compared, tuned, drawn.

Called by ``bigant odom``. Steps the estimator stage of ``robot.control`` and has no filter of its own.
"""
