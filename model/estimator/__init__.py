"""Odometry and foot forces online: an extended Kalman filter whose process is the slip model.

Called through ``model.estimator.filter`` by the estimator stage of the control step. Knows no clock and no
log.
"""
