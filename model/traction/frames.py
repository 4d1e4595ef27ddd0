"""Traction over many frames with given loads: one solver for the model over frames and for the diagnosis.

The diagnosis asks for more: loads may be measured ones, the body may be pushed or dragged, feet may give
sideways, friction may fall with speed, feet at rest may creep. Without any of these the answers are those
of the model, and as the creep vanishes they come to them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from model.compiled import FLAG, compile_for, compiled
from model.errors import ModelError
from model.support.kernel import ROWS, SPEED_X, SPEED_Y, X, Y
from model.traction.coulomb_frame import balance_frame, balance_space
from model.traction.coulomb_kernel import FootLaw
from model.traction.kernel import (
    CREEP_SPEED_M_S,
    FINE,
    coulomb_scale,
    lay_anisotropy,
    traction_kernel,
)
from model.values.arrays import BoolArray, FloatArray, IntArray, given_rows, readonly

NOT_A_NUMBER = 1
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


class SlidingFeet(NamedTuple):
    """N feet on the ground in F frames.

    Attributes:
        position_m: In the body frame, (F, N, 2 or 3).
        speed_m_s: Their velocities in the body frame, (F, N, 2 or 3).
        limit_n: mu N of each foot, 0 in the air, (F, N).
        anisotropy_B: w of each foot, (F or 1, N, 2).
    """

    position_m: FloatArray
    speed_m_s: FloatArray
    limit_n: FloatArray
    anisotropy_B: FloatArray  # noqa: N815 - frame suffix


class Given(NamedTuple):
    """F frames of N feet; what says (1 or F) may be the same for all.

    Attributes:
        feet: Places of the feet, body axes, (F, N, 2 or 3) [m].
        speed: Their velocities, the same [m/s].
        limit: mu N, (F, N) [N].
        w: Anisotropy, (1 or F, N, 2).
        outside: What else acts, as in ``model.traction.coulomb_frame.balance_frame``, (F, 5); no rows:
        nothing.
        give: How far feet give over the time between frames, (1 or F, N, 2) [m/(N s)]; no rows: not at all.
        kept: Mass and moment of inertia over their time step, the velocity before the first frame, (3), and
            the time between the frames of a walk [s], 0 for frames that do not follow each other, (6,).
        near: Velocity of the body, then forces on the feet, in answers near the ones sought, (F, 3 + 2 N);
            no rows: none are known.
    """

    feet: FloatArray
    speed: FloatArray
    limit: FloatArray
    w: FloatArray
    outside: FloatArray
    give: FloatArray
    kept: FloatArray
    near: FloatArray


class TractionSolutions(NamedTuple):
    """Velocities and forces of F frames of N feet; NaN where there is no answer.

    Attributes:
        velocity_B: vx, vy [m/s], yaw rate [rad/s] in body axes, (F, 3).
        slip_B: Velocity of each foot over the ground, (F, N, 2) [m/s].
        force_xy_B: Ground's horizontal force on each foot, (F, N, 2) [N].
        sticking: Feet at rest under the exact law, (F, N).
        unique: Whether velocity and forces are the only ones that balance, (F,).
        reason: ``model.quasistatic.frames.Reason`` of each frame, (F,); in: why a frame has no loads.
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    slip_B: FloatArray  # noqa: N815
    force_xy_B: FloatArray  # noqa: N815
    sticking: BoolArray
    unique: BoolArray
    reason: IntArray

    @property
    def valid(self) -> BoolArray:
        """(F,) whether the frame has an answer."""
        fine: BoolArray = self.reason == FINE
        return fine


def solve_traction_frames(
    feet: SlidingFeet,
    law: FootLaw,
    pushes: Pushes | None = None,
    period_s: float = 1.0,
    give_m_n: FloatArray | None = None,
    *,
    near: FloatArray | None = None,
    out: TractionSolutions | None = None,
) -> TractionSolutions:
    """Balance each frame.

    Args:
        feet: The feet.
        law: How feet answer slip, in m/s.
        pushes: What else acts; None for nothing.
        period_s: Time between frames; feet that give remember the frame before.
        give_m_n: How far a foot gives under a horizontal force, along body x and y, (F or 1, N, 2).
        near: Where the search of feet that creep or give under Coulomb's law starts: velocities and forces
            of the same frames in conditions that differ a little, (F, 3 + 2 N), of ``near_answers``.
        out: Arrays at hand to write the answer into; frames whose ``reason`` is not 0 are left out, and
            forces of the viscous ansatz are left as -mu N (I + w w^T) slip; None: these are in newtons.

    Raises:
        ModelError: Shapes do not fit, or the exact law is asked for more than stiff feet.
    """
    frames, count = feet.limit_n.shape
    two, one = (frames, count, 2), (1, count, 2)
    wrench = np.zeros((frames, 3)) if pushes is None else pushes.wrench_B
    shapes = (feet.position_m[..., :2].shape, feet.speed_m_s[..., :2].shape, wrench.shape)
    either = (feet.anisotropy_B.shape, one if give_m_n is None else give_m_n.shape)
    if near is not None and near.shape != (frames, 3 + 2 * count):
        raise ModelError(
            f"{frames} frames of {count} feet have no answers near them of {near.shape}"
        )
    if shapes != (two, two, (frames, 3)) or not {two, one}.issuperset(either):
        raise ModelError(f"{frames} frames of {count} feet do not fit shapes {shapes} and {either}")
    outside, kept, give = np.zeros((0, 5)), np.zeros(6), np.zeros((0, count, 2))
    if pushes is not None:
        drag = np.tile([pushes.drag_n_s_m, pushes.drag_nm_s], (frames, 1))
        outside = np.concatenate([wrench, drag], axis=1)
        kept = _kept(pushes.inertia, period_s)
    if give_m_n is not None and give_m_n.any():
        give = give_m_n / period_s
    if law.coulomb and law.rest == 0.0 and (outside.any() or kept.any() or give.any()):
        raise ModelError(
            "feet that give or a body that is pushed need feet that creep: give a rest speed"
        )
    read = (*feet, outside, give, kept, np.zeros((0, 3 + 2 * count)) if near is None else near)
    answer = answers_for(frames, count) if out is None else out
    prepare()
    _balance(
        Given(*map(given_rows, read)),
        FootLaw(law.coulomb, *map(float, law[1:])),
        out is None,
        answer,
    )
    if out is None:
        for values in answer:
            readonly(values)
    return answer


TractionSolver = Callable[
    [SlidingFeet, FootLaw, Pushes | None, float, FloatArray], TractionSolutions
]


def near_answers(velocity_B: FloatArray, force_xy_B: FloatArray) -> FloatArray:  # noqa: N803
    """Return what balances near an answer start from, (F, 3 + 2 N), given (F, 3) and (F, N, 2)."""
    return np.column_stack([velocity_B, force_xy_B.reshape(len(velocity_B), -1)])


def _kept(inertia: Inertia | None, period_s: float) -> FloatArray:
    if inertia is None:
        return np.zeros(6)
    walk = inertia.since_s is None
    step = period_s if inertia.since_s is None else inertia.since_s
    return np.array([
        inertia.mass_kg / step, inertia.about_z_kg_m2 / step, *inertia.last_B, period_s * walk,
    ])  # fmt: skip


def answers_for(frames: int, count: int) -> TractionSolutions:
    """Return room for the answers of so many frames of so many feet."""
    return TractionSolutions(
        np.empty((frames, 3)),
        np.empty((frames, count, 2)),
        np.empty((frames, count, 2)),
        np.zeros((frames, count), dtype=np.bool_),
        np.zeros(frames, dtype=np.bool_),
        np.zeros(frames, dtype=np.int64),
    )


@compiled
def _balance(given: Given, law: FootLaw, newtons: bool, out: TractionSolutions) -> None:
    feet, speed, limit, w, others, give, kept, near = given
    velocity, slip, force, sticking, unique, reason = out
    frames, count = limit.shape
    work, loads, mu = np.zeros((ROWS, count)), np.empty(count), np.ones(count)
    twist, before, rest = np.zeros(3), kept[2:5].copy(), np.zeros(count, dtype=np.bool_)
    outside = np.zeros(5 if others.shape[0] > 0 else 0)
    elastic = np.zeros((count if give.shape[0] > 0 else 0, 6))
    space = balance_space(count)
    heavy = kept[0] > 0.0 or kept[1] > 0.0
    plain = not law.coulomb and law.static_ratio == 1.0 and give.shape[0] == 0
    # where friction falls with speed several velocities may balance: it stays near the frame before
    near_known = near.shape[0] > 0 and law.coulomb and law.static_ratio == 1.0
    warm, last = False, speed.shape[2] - 1
    for f in range(frames):
        check = 0.0
        for k in range(count):
            c, x, y = limit[f, k], feet[f, k, 0], feet[f, k, 1]
            x_speed, y_speed = speed[f, k, 0], speed[f, k, 1]
            loads[k], work[X, k], work[Y, k] = c, x, y
            work[SPEED_X, k], work[SPEED_Y, k] = x_speed, y_speed
            check += 0.0 * (c + x + y + x_speed + y_speed + speed[f, k, last])
        if f == 0 or w.shape[0] > 1:
            lay_anisotropy(w[f], work)
        for k in range(elastic.shape[0]):
            if f == 0 or give.shape[0] > 1:
                elastic[k, 0], elastic[k, 1] = give[f, k, 0], give[f, k, 1]
        if reason[f] == FINE and check != 0.0:
            reason[f] = NOT_A_NUMBER
        if reason[f] == FINE:
            pushed = False
            for i in range(outside.size):
                outside[i] = others[f, i]
            if heavy and np.isfinite(before[0] + before[1] + before[2]):
                # kept in the world while the body turns
                turned = before[2] * kept[5]
                outside[0] += kept[0] * (before[0] + turned * before[1])
                outside[1] += kept[0] * (before[1] - turned * before[0])
                outside[2] += kept[1] * before[2]
                outside[3] += kept[0]
                outside[4] += kept[1]
            for i in range(outside.size):
                pushed = pushed or outside[i] != 0.0
            if plain and not pushed:
                reason[f] = traction_kernel(work, loads, mu, twist, slip[f], force[f])
                unique[f] = True
                if newtons and reason[f] == FINE:
                    scale = coulomb_scale(slip[f], force[f], CREEP_SPEED_M_S)
                    for k in range(count):
                        force[f, k, 0] *= scale
                        force[f, k, 1] *= scale
            else:
                known = near_known and f > 0 and np.isfinite(near[f, 0] + near[f - 1, 0])
                for k in range(elastic.shape[0]):
                    elastic[k, 4], elastic[k, 5] = elastic[k, 2], elastic[k, 3]
                    if known:  # what is near changes as the answer does
                        elastic[k, 4] += near[f, 3 + 2 * k] - near[f - 1, 3 + 2 * k]
                        elastic[k, 5] += near[f, 4 + 2 * k] - near[f - 1, 4 + 2 * k]
                if warm and law.rest > 0.0 and known:
                    for i in range(3):
                        twist[i] = velocity[f - 1, i] + near[f, i] - near[f - 1, i]
                elif warm and law.rest > 0.0 and f > 1 and np.isfinite(velocity[f - 2, 0]):
                    for i in range(3):  # the search starts where the two frames before lead to
                        twist[i] = 2.0 * velocity[f - 1, i] - velocity[f - 2, i]
                reason[f], unique[f] = balance_frame(
                    work, loads, mu, law, outside, elastic, warm, twist, slip[f], force[f], rest,
                    count > 0, space,
                )  # fmt: skip
        warm = reason[f] == FINE
        if warm:
            for i in range(3):
                velocity[f, i] = twist[i]
                if kept[5] > 0.0:
                    before[i] = twist[i]
            for k in range(count):
                sticking[f, k] = rest[k]
            for k in range(elastic.shape[0]):
                elastic[k, 2], elastic[k, 3] = force[f, k, 0], force[f, k, 1]
        else:
            velocity[f, :] = np.nan
            slip[f, :, :] = np.nan
            force[f, :, :] = np.nan
            sticking[f, :] = False
            unique[f] = False


@cache
def prepare() -> None:
    """Compile for the arrays of ``given_rows`` and ``answers_for``, and for nothing else after."""
    given = Given(*(given_rows(np.zeros((1,) * axes)) for axes in (3, 3, 2, 3, 2, 3, 1, 2)))
    compile_for(_balance, given, FootLaw(False), FLAG, answers_for(1, 1))
