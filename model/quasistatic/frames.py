"""The model over many frames at once: arrays in, arrays out, one row a frame.

A frame without an answer (the robot tips, nothing is loaded, the input is no number) is NaN with
``reason`` set; the other frames are not affected.
"""

import enum
from typing import NamedTuple

import numpy as np

from model.errors import ModelError
from model.support.frames import SupportSolutions, solve_support_frames
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import SlidingFeet, answers_for, solve_traction_frames
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


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
    NEGATIVE = 7  # load or a stiffness not positive, or a friction coefficient below 0


class FrameSolutions(NamedTuple):
    """The model's answer for F frames of N feet.

    Attributes:
        pose: slope_x, slope_y, height [m] of each frame, (F, 3).
        load_n: Ground's vertical force on each foot, (F, N) [N]; 0 in the air.
        switches: Steps of the contact search, (F,).
        velocity_B: vx, vy [m/s], yaw rate [rad/s] in body axes, (F, 3).
        slip_B: Velocity of each foot over the ground, body axes, (F, N, 2) [m/s]; also in the air.
        force_xy_B: Ground's horizontal force on each foot, body axes, (F, N, 2). Coulomb: [N].
            Viscous: the bare ansatz -mu N (I + w w^T) slip, in newtons up to one scale a frame
            (``model.traction.force_scale``).
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
    anisotropy_B: FloatArray | None = None,  # noqa: N803
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
        anisotropy_B: w where it turns from frame to frame, (F, N, 2); ``contact``'s if None.

    Raises:
        ModelError: Shapes do not fit.
    """
    position, speed = feet.position_m, feet.velocity_m_s
    if position.ndim != 3 or position.shape[2] != 3 or speed.shape != position.shape:
        raise ModelError(
            f"feet must be two arrays (frames, legs, 3), not {position.shape} and {speed.shape}"
        )
    frames, count, _ = position.shape
    problem = _parameter_problem(contact, weight_n, count)
    w = contact.anisotropy[None] if anisotropy_B is None else anisotropy_B
    turning = (frames, count, 2)
    if anisotropy_B is not None and (w.shape != turning or not np.isfinite(w).all()):
        raise ModelError(f"anisotropy must be {turning} numbers, not {w.shape}")
    switches = np.zeros(frames, dtype=np.int64)
    sliding = answers_for(frames, count)
    answer = FrameSolutions(np.empty((frames, 3)), np.empty((frames, count)), switches, *sliding)
    if problem is Reason.FINE:
        ground = np.zeros((1, count)) if ground_m is None else np.atleast_2d(ground_m)
        standing = SupportSolutions(*answer[:3], answer.reason)
        solve_support_frames(position, ground, contact.stiffness, weight_n, standing)
        if tilt_coupling:
            speed = speed.copy()
            speed[..., :2] += answer.pose[:, None, :2] * [1.0, -1.0] * speed[..., 2:]
        limit, foot_law = contact.mu * answer.load_n, FootLaw(law is FrictionLaw.COULOMB)
        solve_traction_frames(SlidingFeet(position, speed, limit, w), foot_law, out=sliding)
    else:
        for values in answer:
            values.fill(np.nan if values.dtype == np.float64 else 0)
        answer.reason.fill(problem)
    for values in answer:
        readonly(values)
    return answer


def _parameter_problem(contact: ContactParameters, weight_n: float, count: int) -> Reason:
    shapes = (contact.stiffness.shape, contact.mu.shape, contact.anisotropy.shape)
    if shapes != ((count,), (count,), (count, 2)):
        raise ModelError(
            f"{count} feet need stiffness and mu ({count},) and anisotropy ({count}, 2), not {shapes}"
        )
    if count == 0:
        return Reason.NO_FEET
    numbers = (contact.stiffness, contact.mu, contact.anisotropy, np.array(weight_n))
    if not all(np.isfinite(n).all() for n in numbers):
        return Reason.NOT_A_NUMBER
    if weight_n <= 0 or (contact.stiffness <= 0).any() or (contact.mu < 0).any():
        return Reason.NEGATIVE
    return Reason.FINE
