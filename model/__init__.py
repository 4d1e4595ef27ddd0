"""The model of multi-legged locomotion with slipping (Wu, Zhao, Revzen 2023, arXiv:2310.20669).

Pure functions and values: nothing here knows a clock, a socket, a file or a logger.

Two traps of the source paper, written down once. Its ``q_j`` is a *foot position in the body
frame*, not a joint angle. And it calls ``alpha_x`` pitch in one paragraph and roll in another:
from eqn:zpj ``alpha_x`` is the slope along x (a rotation about y), so we name by axis, ``slope_x``
and ``slope_y``. Forces are always the ground's force on the foot, moments follow the right hand.
"""
