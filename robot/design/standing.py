"""A robot without gaits, as it stands: every joint at its zero, all feet down."""

import numpy as np

from gaits.gait import ShaftMotion
from model.values.arrays import BoolArray, FloatArray

STANDING = "standing"


class StandingStill:
    """A gait that does not move; ``gaits.gait.Gait``.

    Args:
        joints: Number of joints.
        legs: Number of legs.
    """

    name = STANDING
    frequency_hz = 0.0
    start_phase = 0.0

    def __init__(self, joints: int, legs: int) -> None:
        self._joints, self._legs = joints, legs

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return zeros at phases of any shape (...), as (..., J)."""
        zeros = np.zeros((*np.shape(phase), self._joints))
        return ShaftMotion(zeros, zeros, zeros)

    def stance(self, phase: FloatArray | float) -> BoolArray:
        """Return that all legs stand, (..., N)."""
        return np.ones((*np.shape(phase), self._legs), dtype=np.bool_)

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return that nothing moves."""
        return 0.0, 0.0
