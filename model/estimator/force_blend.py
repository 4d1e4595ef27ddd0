"""Predicted foot forces, weighed between the filter's and those of the robot file alone.

The filter knows friction better, the open loop has the simpler law where feet hardly slip. Which is nearer
to what the sensors measure differs from gait to gait and axis to axis, so it is measured: the weights of
the horizontal axes are the least squares of the last seconds, all of it the open loop's before.
"""

import numpy as np

from model.compiled import NUMBER, compile_for, compiled, given, out
from model.support.kernel import ROWS, support_kernel
from model.traction.kernel import (
    CREEP_SPEED_M_S,
    coulomb_scale,
    foot_speeds,
    lay_anisotropy,
    traction_kernel,
)
from model.values.arrays import FloatArray, readonly
from model.values.estimate import ForceMemory
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

MEMORY_RECORDS = 1000.0  # ten seconds
PRIOR = 1e-5  # squared share of the weight by which they must differ before that counts


@compiled
def open_loop_kernel(
    feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray, mu: FloatArray,
    anisotropy: FloatArray, weight: float, share: FloatArray,
) -> int:  # fmt: skip
    """Forces of the viscous-Coulomb model at the robot file's values.

    Args:
        feet: (N, 3) [m].
        feet_velocity: (N, 3) [m/s].
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: (N, 2).
        weight: [N].
        share: Out: forces over the weight, (N, 3).

    Returns:
        0, or why there is no answer.
    """
    count = feet.shape[0]
    work, tilt, loads, twist = np.empty((ROWS, count)), np.empty(3), np.empty(count), np.empty(3)
    side, pull = np.zeros((count, 2)), np.zeros((count, 2))
    lay_anisotropy(anisotropy, work)
    place, speed = feet.copy(), feet_velocity.copy()
    spring, grip = stiffness.copy(), mu.copy()
    reason = support_kernel(place, np.zeros(count), spring, weight, tilt, loads, work)
    if reason < 0:
        return -reason
    if not foot_speeds(speed, work):
        return 1
    reason = traction_kernel(work, loads, grip, twist, side, pull)
    if reason != 0:
        return reason
    scale = coulomb_scale(side, pull, CREEP_SPEED_M_S) / weight
    for k in range(count):
        share[k, 0], share[k, 1] = scale * pull[k, 0], scale * pull[k, 1]
        share[k, 2] = loads[k] / weight
    return 0


def at_start() -> ForceMemory:
    """Nothing is known of either."""
    nothing = readonly(np.zeros(2))
    return ForceMemory(nothing, nothing)


def open_loop(feet: FootMotion, contact: ContactParameters, weight_n: float) -> FloatArray:
    """Forces of the robot file alone over the weight, (N, 3); NaN where it has no answer."""
    share = np.empty((len(contact.mu), 3))
    reason = open_loop_kernel(
        np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, weight_n, share,
    )  # fmt: skip
    return share if reason == 0 else np.full_like(share, np.nan)


def learn(
    before: ForceMemory, measured: FloatArray, filtered: FloatArray, plain: FloatArray
) -> ForceMemory:
    """Compare both with a new record of the forces.

    Args:
        before: What is known of them.
        measured: Forces over the weight, (N, 3); NaN where there are none.
        filtered: The filter's.
        plain: Of ``open_loop``.
    """
    apart, left = (filtered - plain)[:, :2], (measured - plain)[:, :2]
    known = np.isfinite(apart + left).all(axis=1)
    if not known.any():
        return before
    new = 1.0 / MEMORY_RECORDS
    apart, left = apart[known], left[known]
    return ForceMemory(
        readonly((1.0 - new) * before.apart + new * (apart**2).sum(axis=0)),
        readonly((1.0 - new) * before.agree + new * (apart * left).sum(axis=0)),
    )


def blended(memory: ForceMemory, filtered: FloatArray, plain: FloatArray) -> FloatArray:
    """Return what is predicted, (N, 3): vertical forces are the filter's, which learns from them."""
    if not np.isfinite(plain).all():
        return filtered
    share = np.clip(memory.agree / (memory.apart + PRIOR), 0.0, 1.0)
    both = filtered.copy()
    both[:, :2] = plain[:, :2] + share * (filtered - plain)[:, :2]
    return both


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(open_loop_kernel, *given(2, 2, 1, 1, 2), NUMBER, *out(2))
