"""Traction over many frames with given loads, and what ``model.quasistatic.frames`` leaves out.

For the diagnosis of measured runs: loads may be measured ones, the body may be pushed or dragged, feet
may give sideways, friction may fall with speed. Without any of these the answers are those of
``model.quasistatic.frames``, but for the creep of feet at rest (see ``model.traction.frames_kernel``).
"""

from dataclasses import dataclass

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, given, out
from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw
from model.traction import frames_kernel as kernel
from model.values.arrays import BoolArray, FloatArray, readonly

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


@dataclass(frozen=True, slots=True)
class FootLaw:
    """How a foot answers slip.

    Attributes:
        friction: The law.
        static_ratio: Friction at rest over friction when sliding fast.
        static_speed_m_s: Slip at which most of the difference is gone.
        rest_speed_m_s: Slip below which a foot under Coulomb's law creeps.
    """

    friction: FrictionLaw = FrictionLaw.VISCOUS
    static_ratio: float = 1.0
    static_speed_m_s: float = 0.01
    rest_speed_m_s: float = REST_SPEED_M_S


@dataclass(frozen=True, slots=True, eq=False)
class TractionSolutions:
    """Velocities and forces of F frames of N feet; NaN where ``valid`` is False.

    Attributes:
        velocity_B: vx, vy [m/s], yaw rate [rad/s] in body axes, (F, 3).
        slip_B: Velocity of each foot over the ground, (F, N, 2) [m/s].
        force_xy_B: Ground's horizontal force on each foot, (F, N, 2) [N].
        valid: (F,) False with fewer than two loaded feet or numbers missing.
    """

    velocity_B: FloatArray  # noqa: N815
    slip_B: FloatArray  # noqa: N815
    force_xy_B: FloatArray  # noqa: N815
    valid: BoolArray


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
        law: How feet answer slip.
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
    give = np.zeros((1, count, 2)) if give_m_n is None else give_m_n
    if give.shape not in {two, (1, count, 2)}:
        raise ModelError(f"how feet give must be (frames or 1, {count}, 2), not {give.shape}")
    out = TractionSolutions(
        velocity_B=np.empty((frames, 3)),
        slip_B=np.empty(two),
        force_xy_B=np.empty(two),
        valid=np.zeros(frames, dtype=np.bool_),
    )
    prepare()
    kernel.traction_frames_kernel(
        _rows(feet_xy_m),
        _rows(feet_speed_m_s),
        _rows(limit_n),
        _rows(anisotropy_B),
        _rows(pushes.wrench_B),
        np.array([pushes.drag_n_s_m, pushes.drag_nm_s], dtype=np.float64),
        *_kept(pushes.inertia, period_s),
        law.friction is FrictionLaw.COULOMB,
        law.rest_speed_m_s,
        _rows(give),
        period_s,
        law.static_ratio,
        law.static_speed_m_s,
        out.velocity_B,
        out.slip_B,
        out.force_xy_B,
        out.valid,
    )
    for name in TractionSolutions.__slots__:
        readonly(getattr(out, name))
    return out


def _kept(inertia: Inertia | None, period_s: float) -> tuple[FloatArray, FloatArray, bool]:
    """Inertia over its time step, (2,), the velocity at first, and whether it is that of a walk."""
    if inertia is None:
        return np.zeros(2), np.full(3, np.nan), False
    step = period_s if inertia.since_s is None else inertia.since_s
    size = np.array([inertia.mass_kg, inertia.about_z_kg_m2]) / step
    return size, _rows(inertia.last_B), inertia.since_s is None


def _rows(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(
        kernel.traction_frames_kernel, *given(3, 3, 2, 3, 2, 1, 1, 1), FLAG, FLAG,
        NUMBER, *given(3),
        *(NUMBER,) * 3, *out(2, 3, 3), *out(1, kind=FLAG),
    )  # fmt: skip
