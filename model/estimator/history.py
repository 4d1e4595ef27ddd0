"""The estimator with a memory of the last moments, for samples that come late or out of order.

A late sample goes to the tick it belongs to, and the ticks since then are done again: the answer is the
one that the sample in time would have given, bit for bit. What is older than the memory is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.estimator.filter import Estimator
from model.values.arrays import FloatArray
from model.values.estimate import Estimate, EstimatorState, OdometryInputs


@dataclass(frozen=True, slots=True, eq=False)
class LateSample:
    """An absolute pose measured before the newest tick.

    Attributes:
        t_ns: When it was measured.
        pose_W: x, y [m], yaw [rad], (3,).
        pose_sd_m: Standard deviation of x and y; NaN for that of the settings.
        yaw_sd_rad: The same of the yaw.
    """

    t_ns: int
    pose_W: FloatArray  # noqa: N815 - frame suffix
    pose_sd_m: float = np.nan
    yaw_sd_rad: float = np.nan


@dataclass(frozen=True, slots=True, eq=False)
class EstimatorMemory:
    """State now, and the ticks that led to it.

    Attributes:
        state: State after the newest tick.
        ticks: State before each tick that is still remembered, and what was known in it.
        refused: Late samples that found no tick.
    """

    state: EstimatorState
    ticks: tuple[tuple[EstimatorState, OdometryInputs], ...] = ()
    refused: int = 0


def advance(
    estimator: Estimator, memory: EstimatorMemory, inputs: OdometryInputs, memory_s: float
) -> tuple[EstimatorMemory, Estimate]:
    """Advance by a tick and remember it.

    Args:
        estimator: The filter.
        memory: State so far.
        inputs: The tick.
        memory_s: How late a sample may be [s].
    """
    limit_ns = round(memory_s * 1e9)
    ticks = (*memory.ticks, (memory.state, inputs))
    first = 0
    while abs(inputs.t_ns - ticks[first][1].t_ns) > limit_ns:
        first += 1
    state, estimate = estimator.step(memory.state, inputs)
    return EstimatorMemory(state, ticks[first:], memory.refused), estimate


def use_late(
    estimator: Estimator, memory: EstimatorMemory, samples: Sequence[LateSample]
) -> tuple[EstimatorMemory, Estimate | None]:
    """Put samples into the first ticks that are not before them, and do the ticks since again, once.

    Returns:
        The memory, and the newest estimate, corrected. It is None if no sample was of use: older than
        the memory, newer than the newest tick (it then belongs to the next one), or heard already.
    """
    ticks, refused = list(memory.ticks), memory.refused
    earliest = len(ticks)
    for sample in samples:
        place = _place(ticks, sample)
        if place is None:
            refused += 1
            continue
        state, inputs = ticks[place]
        pose, sd_m, sd_rad = sample.pose_W, sample.pose_sd_m, sample.yaw_sd_rad
        heard = replace(inputs, pose_W=pose, pose_sd_m=sd_m, yaw_sd_rad=sd_rad)
        ticks[place] = (state, heard)
        earliest = min(earliest, place)
    if earliest == len(ticks):
        return replace(memory, refused=refused), None
    state, redone, estimate = ticks[earliest][0], ticks[:earliest], None
    for _, inputs in ticks[earliest:]:
        redone.append((state, inputs))
        state, estimate = estimator.step(state, inputs)
    return EstimatorMemory(state, tuple(redone), refused), estimate


def _place(
    ticks: Sequence[tuple[EstimatorState, OdometryInputs]], sample: LateSample
) -> int | None:
    """Number of the tick that a sample belongs to, None if there is none or it has a pose already."""
    place = next((i for i, tick in enumerate(ticks) if tick[1].t_ns >= sample.t_ns), None)
    if place is None or sample.t_ns < ticks[0][0].t_ns or ticks[place][1].pose_W is not None:
        return None
    return place
