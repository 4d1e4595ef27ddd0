"""A gait of one's own, for ``bigant drive --gait examples/own_gait.py``: a tripod without corners.

Each shaft turns as 2 pi x - bend sin(2 pi x), which is slowest at mid-stance, x = 0, and smooth everywhere.
"""

import numpy as np

BEND = 0.7  # how much slower it is in stance
STEER = 0.3  # share by which full steering changes that
DOWN_RAD = 1.25  # of shaft angle on both sides of mid-stance


class SmoothTripod:
    """Every other leg of each side together, the others half a cycle later."""

    frequency_hz = 0.12

    def __init__(self, legs):
        x, y = legs.shaft_position[:, 0], legs.shaft_position[:, 1]
        self.side = np.sign(y)
        behind = (self.side[:, None] == self.side) & (x[None, :] < x[:, None])
        self.mid_stance = 0.5 * ((behind.sum(axis=1) + (y < 0)) % 2)

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
    return SmoothTripod(legs)
