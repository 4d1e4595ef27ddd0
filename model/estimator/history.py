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
from model.values.legs import FootForces


@dataclass(frozen=True, slots=True, eq=False)
class LateSample:
    """Something measured before the newest tick.

    Attributes:
        t_ns: When it was measured.
        forces: Foot forces, or None.
        pose_W: Absolute x, y [m], yaw [rad], (3,), or None.
        yaw_rate_rad_s: Of a gyro [rad/s], or NaN.
        pose_sd_m: Standard deviation of x and y; NaN for that of the settings.
        yaw_sd_rad: The same of the yaw.
    """

    t_ns: int
    forces: FootForces | None = None
    pose_W: FloatArray | None = None  # noqa: N815 - frame suffix
    yaw_rate_rad_s: float = np.nan
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
    first = next(i for i, tick in enumerate(ticks) if abs(inputs.t_ns - tick[1].t_ns) <= limit_ns)
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
        ticks[place] = (state, _with(inputs, sample))
        earliest = min(earliest, place)
    if earliest == len(ticks):
        return replace(memory, refused=refused), None
    state, redone, estimate = ticks[earliest][0], ticks[:earliest], None
    for _, inputs in ticks[earliest:]:
        redone.append((state, inputs))
        state, estimate = estimator.step(state, inputs)
    return EstimatorMemory(state, tuple(redone), refused), estimate


class EstimatorHistory:
    """An estimator and the ticks of the last half second, as one thing that changes.

    Args:
        estimator: The filter.
        state: State to begin with; a fresh one if None.
        memory_s: How late a sample may be [s].
    """

    def __init__(
        self, estimator: Estimator, state: EstimatorState | None = None, memory_s: float = 0.5
    ) -> None:
        self._estimator = estimator
        self._memory = EstimatorMemory(state if state is not None else estimator.initial())
        self._memory_s = memory_s

    @property
    def state(self) -> EstimatorState:
        """State after the newest tick."""
        return self._memory.state

    @property
    def refused(self) -> int:
        """Late samples that found no tick."""
        return self._memory.refused

    def step(self, inputs: OdometryInputs) -> Estimate:
        """Advance by a tick and remember it."""
        self._memory, estimate = advance(self._estimator, self._memory, inputs, self._memory_s)
        return estimate

    def late(self, sample: LateSample) -> Estimate | None:
        """Use a late sample, as ``use_late`` does."""
        self._memory, estimate = use_late(self._estimator, self._memory, (sample,))
        return estimate


def _place(
    ticks: Sequence[tuple[EstimatorState, OdometryInputs]], sample: LateSample
) -> int | None:
    """Number of the tick that a sample belongs to, None if there is none or it knows as much."""
    place = next((i for i, tick in enumerate(ticks) if tick[1].t_ns >= sample.t_ns), None)
    if place is None or sample.t_ns < ticks[0][0].t_ns or not _adds(ticks[place][1], sample):
        return None
    return place


def _with(inputs: OdometryInputs, sample: LateSample) -> OdometryInputs:
    turning = np.isfinite(sample.yaw_rate_rad_s)
    seen = sample if sample.pose_W is not None else inputs
    return replace(
        inputs,
        forces=sample.forces if sample.forces is not None else inputs.forces,
        pose_W=seen.pose_W,
        pose_sd_m=seen.pose_sd_m,
        yaw_sd_rad=seen.yaw_sd_rad,
        yaw_rate_rad_s=sample.yaw_rate_rad_s if turning else inputs.yaw_rate_rad_s,
    )


def _adds(inputs: OdometryInputs, sample: LateSample) -> bool:
    """Whether a sample holds something that this tick does not know yet."""
    forces = sample.forces is not None and (
        inputs.forces is None or inputs.forces.t_ns < sample.forces.t_ns
    )
    turning = np.isfinite(sample.yaw_rate_rad_s) and not np.isfinite(inputs.yaw_rate_rad_s)
    return bool(forces or turning or (sample.pose_W is not None and inputs.pose_W is None))
