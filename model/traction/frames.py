"""Traction over many frames with given loads.

For the diagnosis of measured runs: loads may be measured ones, the body may be pushed or dragged, feet may
give sideways, friction may fall with speed, feet at rest may creep. The solver is that of
``model.quasistatic.frames``: without any of these the answers are the same, and as the creep vanishes they
come to them.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames_kernel import (
    Given,
    TractionSolutions,
    answers_for,
    balance_frames,
    rows,
)
from model.values.arrays import FloatArray, readonly

# Slip below which a foot creeps instead of sliding: far below what motion capture can tell.
REST_SPEED_M_S = 5e-5


@dataclass(frozen=True, slots=True, eq=False)
class Inertia:
    """What keeps the body's velocity.

    Attributes:
        mass_kg: Along the ground.
        about_z_kg_m2: About the vertical through the body's origin.
        last_B: Velocity when the time began, (3,) [m/s, rad/s], body axes; NaN where it is not known.
        since_s: Time since then; None for frames of one walk, each of which follows the one before.
    """

    mass_kg: float
    about_z_kg_m2: float
    last_B: FloatArray  # noqa: N815 - frame suffix
    since_s: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Pushes:
    """What acts on the body besides its feet, F frames.

    Attributes:
        wrench_B: Force x, y [N] and moment about z through the origin [N m], body axes, (F, 3).
        drag_n_s_m: Force against the body's velocity over its size.
        drag_nm_s: Moment against its yaw rate over its size.
        inertia: What keeps its velocity; None where feet and pushes alone decide it.
    """

    wrench_B: FloatArray  # noqa: N815 - frame suffix
    drag_n_s_m: float = 0.0
    drag_nm_s: float = 0.0
    inertia: Inertia | None = None


def solve_traction_frames(
    feet_xy_m: FloatArray,
    feet_speed_m_s: FloatArray,
    limit_n: FloatArray,
    anisotropy_B: FloatArray,  # noqa: N803
    law: FootLaw,
    pushes: Pushes,
    period_s: float,
    give_m_n: FloatArray | None = None,
) -> TractionSolutions:
    """Balance each frame.

    Args:
        feet_xy_m: Feet in the body frame, (F, N, 2).
        feet_speed_m_s: Their velocities in the body frame, (F, N, 2).
        limit_n: mu N of each foot, 0 in the air, (F, N).
        anisotropy_B: w of each foot, (F or 1, N, 2).
        law: How feet answer slip, in m/s.
        pushes: What else acts.
        period_s: Time between frames; feet that give remember the frame before.
        give_m_n: How far a foot gives under a horizontal force, along body x and y, (F or 1, N, 2).

    Raises:
        ModelError: Shapes do not fit.
    """
    frames, count = limit_n.shape
    two = (frames, count, 2)
    shapes = (feet_xy_m.shape, feet_speed_m_s.shape, pushes.wrench_B.shape)
    if shapes != (two, two, (frames, 3)) or anisotropy_B.shape not in {two, (1, count, 2)}:
        raise ModelError(f"{frames} frames of {count} feet do not fit shapes {shapes}")
    give = np.zeros((0, count, 2)) if give_m_n is None else give_m_n / period_s
    if give.shape not in {(0, count, 2), (1, count, 2), two}:
        raise ModelError(f"how feet give must be (frames or 1, {count}, 2), not {give.shape}")
    drag = np.tile([pushes.drag_n_s_m, pushes.drag_nm_s], (frames, 1))
    given = Given(
        rows(feet_xy_m), rows(feet_speed_m_s), rows(limit_n), rows(anisotropy_B),
        rows(np.concatenate([pushes.wrench_B, drag], axis=1)),
        rows(give if give.any() else give[:0]),
        rows(_kept(pushes.inertia, period_s)),
    )  # fmt: skip
    out = answers_for(frames, count)
    balance_frames(given, law, out, newtons=True)
    for values in out:
        readonly(values)
    return out


def _kept(inertia: Inertia | None, period_s: float) -> FloatArray:
    if inertia is None:
        return np.zeros(6)
    walk = inertia.since_s is None
    step = period_s if inertia.since_s is None else inertia.since_s
    return np.array([
        inertia.mass_kg / step, inertia.about_z_kg_m2 / step, *inertia.last_B, period_s * walk,
    ])  # fmt: skip
