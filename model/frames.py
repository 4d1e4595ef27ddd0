"""The model over many frames at once: arrays in, arrays out, one row a frame.

A frame without an answer (the robot tips, nothing is loaded, the input is no number) is NaN with
``reason`` set; the frames beside it are not touched by it.
"""

import enum
from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.params import ContactParameters
from model.signals import BoolArray, FloatArray, FootMotion, IntArray, readonly


class FrictionLaw(enum.Enum):
    """How a loaded foot resists slipping."""

    VISCOUS = "viscous"  # the paper's viscous-Coulomb ansatz, F = -mu N slip
    COULOMB = "coulomb"  # |F| <= mu N, against the slip


class Reason(enum.IntEnum):
    """Why a frame has no answer, or what to know about the one it has."""

    FINE = 0
    NOT_A_NUMBER = 1  # a position, velocity, stiffness or the load
    NO_FEET = 2
    TIPS = 3  # the centre of mass is not above the feet
    NO_CONVERGENCE = 4  # a fault of ours: please report the pose
    TOO_FEW_FEET = 5  # fewer than two loaded feet: turning is not determined
    ONE_POINT = 6  # the loaded feet stand in one point
    NEGATIVE = 7  # load or a stiffness is not positive


@dataclass(frozen=True, slots=True, eq=False)
class FrameSolutions:
    """The model's answer for F frames of N feet.

    Attributes:
        pose: slope_x, slope_y, height [m] of each frame, (F, 3).
        load_n: Ground's vertical force on each foot, (F, N) [N]; 0 in the air.
        switches: Steps of the contact search, (F,).
        velocity_B: vx, vy [m/s], yaw rate [rad/s] in body axes, (F, 3).
        slip_B: Velocity of each foot over the ground, body axes, (F, N, 2) [m/s]; also in the air.
        force_xy_B: Ground's horizontal force on each foot, body axes, (F, N, 2). Coulomb: [N].
            Viscous: the bare ansatz -mu N (I + w w^T) slip, in newtons up to one scale a frame
            (``model.force_scale``).
        sticking: Coulomb: feet at rest, (F, N); viscous: all False.
        unique: (F,) False where forces (Coulomb with several sticking feet) or the velocity (a flat
            balance, like the median of an even number) are one choice among many.
        reason: ``Reason`` of each frame, (F,).
    """

    pose: FloatArray
    load_n: FloatArray
    switches: IntArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    slip_B: FloatArray  # noqa: N815
    force_xy_B: FloatArray  # noqa: N815
    sticking: BoolArray
    unique: BoolArray
    reason: IntArray

    @property
    def valid(self) -> BoolArray:
        """(F,) whether the frame has an answer."""
        fine: BoolArray = self.reason == Reason.FINE
        return fine

    @property
    def contact(self) -> BoolArray:
        """(F, N) whether the foot is loaded."""
        loaded: BoolArray = self.load_n > 0
        return loaded


def solve_frames(
    feet: FootMotion,
    contact: ContactParameters,
    weight_n: float,
    *,
    law: FrictionLaw = FrictionLaw.VISCOUS,
    tilt_coupling: bool = False,
    ground_m: FloatArray | None = None,
) -> FrameSolutions:
    """Support, then traction, for every frame.

    Args:
        feet: Unloaded feet in the body frame, (F, N, 3) each [m], [m/s].
        contact: Leg springs and friction of the N legs.
        weight_n: Weight carried [N].
        law: Friction law.
        tilt_coupling: Add the horizontal share of the feet's vertical speed on a tilted body,
            [slope_x, -slope_y] q'_z (the last term of eqn:vxy, erratum E2).
        ground_m: Height of the level ground under each foot, (F, N) or (N,) [m]; 0 if None.

    Raises:
        ModelError: Shapes do not fit.
    """
    raise NotImplementedError
