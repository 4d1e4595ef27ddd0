"""The part of a tick that the model takes, in one compiled call: its answer, the companions, the step.

An ordinary tick asks the model around the frame (``frame_kernel``), lets the robots of other tolerances
walk along (``tolerance_kernel``) and moves the state (``process``). Each needs the answer of the one
before, and calling them one by one from Python takes longer than the model itself.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.frame_kernel import neighbourhood_kernel
from model.estimator.neighbourhood import Neighbourhood, add_effects
from model.estimator.process import ProcessStep, walk_kernel
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.tolerance_kernel import tolerance_kernel
from model.estimator.tolerances import Apart, design
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.estimate import AddedByEffects, Companions, EstimatorState
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

NOTHING_ADDED = AddedByEffects(readonly(np.zeros(0)), readonly(np.zeros(0)))


class Stride(NamedTuple):
    """What the model makes of a tick.

    Attributes:
        model: Its answer.
        companions: Where the robots of other tolerances are now.
        apart: What they answered.
        step: Of the process.
    """

    model: Neighbourhood
    companions: Companions
    apart: Apart
    step: ProcessStep


class Moment(NamedTuple):
    """What else there is to a step.

    Attributes:
        dt_s: Its length, above 0 [s].
        dead_legs: Legs without encoder.
        drift: Of ``process.Beside``, (3,).
    """

    dt_s: float
    dead_legs: int
    drift: FloatArray


def stride(
    state: EstimatorState,
    feet: FootMotion,
    contact: ContactParameters,
    settings: Record,
    added: AddedByEffects | None,
    moment: Moment,
) -> Stride | None:
    """Take the step that leads to a tick; None where the model has no answer.

    Args:
        state: Before it.
        feet: At its end, all finite, one behind the other in memory.
        contact: Stiffness and friction of the robot file.
        settings: Of ``record_of``.
        added: What effects add to the model's answer; None without any.
        moment: How long it takes, and what is not known in it.
    """
    dt_s, dead_legs, drift = moment
    mean, before = state.mean, state.companions
    legs, size, signs = len(contact.mu), len(mean), design(len(contact.mu))
    robots, more = len(signs), added if added is not None else NOTHING_ADDED
    rows, slip, sway = np.empty((1 + 3 * legs, 6 + 3 * legs)), np.empty((legs, 2)), np.empty(2)
    twist, resting = np.empty((robots, 3)), np.empty((robots, legs), np.bool_)
    moved, spread = np.empty((robots, 3)), np.empty((3, 3))
    velocity, share = np.empty((robots, 3)), np.empty((robots, legs))
    after, to, noise = np.empty(size), np.empty((size, size)), np.empty((size, size))
    reason = stride_kernel(
        mean, state.covariance, feet.position_m, feet.velocity_m_s, contact.stiffness, contact.mu,
        contact.anisotropy, settings, more.velocity_B, more.load_n, signs, dt_s, dead_legs,
        state.strain, drift, before.twist, before.resting, before.apart, rows, slip, sway, twist,
        resting, moved, velocity, share, spread, after, to, noise,
    )  # fmt: skip
    if reason != 0:
        return None
    for mine in (twist, resting, moved, spread):
        mine.setflags(write=False)
    return Stride(
        Neighbourhood(rows, slip, sway),
        Companions(twist, resting, moved, spread),
        Apart(velocity, share),
        ProcessStep(after, to, noise),
    )


@in_place
@compiled
def stride_kernel(
    mean: FloatArray, covariance: FloatArray, feet: FloatArray, feet_velocity: FloatArray,
    stiffness: FloatArray, mu: FloatArray, anisotropy: FloatArray, settings: Record,
    added_velocity: FloatArray, added_load: FloatArray, design: FloatArray, dt_s: float,
    dead_legs: int, strain: FloatArray, drift: FloatArray, twist_before: FloatArray,
    resting_before: BoolArray, moved_before: FloatArray, rows: FloatArray, slip: FloatArray,
    sway: FloatArray, twist: FloatArray, resting: BoolArray, moved: FloatArray, apart: FloatArray,
    share: FloatArray, spread: FloatArray, after: FloatArray, to: FloatArray, noise: FloatArray,
) -> int:  # fmt: skip
    """Ask the model around a frame, let companions walk along, and move the state.

    Args:
        mean: State, (n,).
        covariance: Of the state, (n, n).
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: Of the robot file, (N,) [N/m].
        mu: Of the robot file, (N,).
        anisotropy: (N, 2).
        settings: Of ``record_of``.
        added_velocity: Of ``AddedByEffects``, (3,); empty without effects.
        added_load: Of ``AddedByEffects``, (N,); empty without effects.
        design: Of ``tolerance_kernel``, (M, N + 4).
        dt_s: Length of the step [s].
        dead_legs: Legs without encoder.
        strain: Of ``process.Beside``, (3,).
        drift: Of ``process.Beside``, (3,).
        twist_before: Of ``Companions``, (M, 3), as are the next two.
        resting_before: (M, N).
        moved_before: Of ``Companions.apart``, (M, 3).
        rows: Out: of ``Neighbourhood``, as are the next two.
        slip: Out: (N, 2) [m/s].
        sway: Out: (2,) [m/s].
        twist: Out: of ``tolerance_kernel``, as are the next five.
        resting: Out: (M, N).
        moved: Out: (M, 3).
        apart: Out: (M, 3).
        share: Out: (M, N).
        spread: Out: covariance of the companions' poses, (3, 3).
        after: Out: of ``walk_kernel``, as are the next two.
        to: Out: (n, n).
        noise: Out: (n, n).

    Returns:
        0, or why the frame has no answer; what is beyond the model is then not written.
    """
    reason = neighbourhood_kernel(
        mean, feet, feet_velocity, stiffness, mu, anisotropy, settings, rows, slip, sway
    )
    if reason != 0:
        return reason
    if added_velocity.size > 0:
        add_effects(rows, added_velocity, added_load)
    for robot in range(twist.shape[0]):
        for i in range(3):
            twist[robot, i], moved[robot, i] = twist_before[robot, i], moved_before[robot, i]
        for k in range(resting.shape[1]):
            resting[robot, k] = resting_before[robot, k]
    tolerance_kernel(
        mean, feet, feet_velocity, stiffness, mu, anisotropy, settings, rows[0], slip, sway, design,
        dt_s, twist, resting, moved, apart, share, spread,
    )  # fmt: skip
    for i in range(to.shape[0]):
        for j in range(to.shape[1]):
            to[i, j], noise[i, j] = 0.0, 0.0
    walk_kernel(
        mean, covariance, rows, slip, settings, dt_s, dead_legs, apart, strain, drift, after, to,
        noise,
    )  # fmt: skip
    return reason


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        stride_kernel, *given(1, 2, 2, 2, 1, 1, 2), settings, *given(1, 1, 2), NUMBER, COUNT,
        *given(1, 1, 2), *given(2, kind=FLAG), *given(2), *out(2, 2, 1, 2), *out(2, kind=FLAG),
        *out(2, 2, 2, 2, 1, 2, 2),
    )  # fmt: skip
