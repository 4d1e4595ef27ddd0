"""A gait of one's own, for ``bigant drive --gait examples/own_gait.py``: a smooth ripple.

Each shaft turns as 2 pi x - bend sin(2 pi x), which is slowest at mid-stance, x = 0, and smooth everywhere.
"""

import numpy as np

BEND = 0.7  # how much slower it is in stance
STEER = 0.3  # share by which full steering changes that
DOWN_RAD = 1.25  # of shaft angle on both sides of mid-stance


class Ripple:
    """On each side a wave from the hind to the front leg; the sides half a cycle apart."""

    frequency_hz = 0.12

    def __init__(self, legs):
        x, y = legs.shaft_position[:, 0], legs.shaft_position[:, 1]
        self.side = np.sign(y)
        beside = self.side[:, None] == self.side
        rank = np.sum(beside & (x[None, :] < x[:, None]), axis=1)  # 0 for the hindmost
        self.mid_stance = rank / beside.sum(axis=1) + np.where(y < 0, 0.5, 0.0)

    def angle(self, phase, steer):
        """Shaft angles [rad] at phases of any shape (...), as (..., legs)."""
        turn = 2 * np.pi * (phase[..., None] - self.mid_stance)
        return turn - BEND * (1 + STEER * steer * self.side) * np.sin(turn)

    def stance(self, phase):
        """Which legs are to be on the ground, (..., legs)."""
        angle = self.angle(phase, 0.0)
        return np.abs((angle + np.pi) % (2 * np.pi) - np.pi) < DOWN_RAD


def make(legs):
    """Return the gait of a robot with these legs."""
    return Ripple(legs)
