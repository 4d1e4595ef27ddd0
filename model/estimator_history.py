"""The estimator with a memory of the last moments, for samples that come late or out of order.

A late sample goes to the tick it belongs to, and the ticks since then are done again: the answer is the
one that the sample in time would have given, bit for bit. What is older than the memory is refused.
"""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from model.estimator import Estimator
from model.estimator_types import EstimatorState, OdometryEstimate, OdometryInputs
from model.signals import FloatArray, FootForces


@dataclass(frozen=True, slots=True, eq=False)
class LateSample:
    """Something measured before the newest tick.

    Attributes:
        t_ns: When it was measured.
        forces: Foot forces, or None.
        pose_W: Absolute x, y [m], yaw [rad], (3,), or None.
        yaw_rate_rad_s: Of a gyro [rad/s], or NaN.
    """

    t_ns: int
    forces: FootForces | None = None
    pose_W: FloatArray | None = None  # noqa: N815 - frame suffix
    yaw_rate_rad_s: float = np.nan


class EstimatorHistory:
    """An estimator and the ticks of the last half second.

    Args:
        estimator: The filter.
        state: State to begin with; a fresh one if None.
        memory_s: How late a sample may be [s].
    """

    def __init__(
        self, estimator: Estimator, state: EstimatorState | None = None, memory_s: float = 0.5
    ) -> None:
        self._estimator = estimator
        self.state = state if state is not None else estimator.initial()
        self._memory_ns = round(memory_s * 1e9)
        self._ticks: deque[tuple[EstimatorState, OdometryInputs]] = deque()
        self.refused = 0

    def step(self, inputs: OdometryInputs) -> OdometryEstimate:
        """Advance by a tick and remember it."""
        self._ticks.append((self.state, inputs))
        newest = inputs.t_ns
        while abs(newest - self._ticks[0][1].t_ns) > self._memory_ns:
            self._ticks.popleft()
        self.state, estimate = self._estimator.step(self.state, inputs)
        return estimate

    def late(self, sample: LateSample) -> OdometryEstimate | None:
        """Use a sample at the first tick that is not before it, and do the ticks since again.

        Returns:
            The newest estimate, corrected; None if the sample is older than the memory, newer than
            the newest tick (it then belongs to the next one), or has been heard already.
        """
        ticks = list(self._ticks)
        place = next((i for i, tick in enumerate(ticks) if tick[1].t_ns >= sample.t_ns), None)
        older = bool(ticks) and sample.t_ns < ticks[0][0].t_ns
        if place is None or older or not _adds(ticks[place][1], sample):
            self.refused += 1
            return None
        inputs = ticks[place][1]
        pose = sample.pose_W if sample.pose_W is not None else inputs.pose_W
        turning = np.isfinite(sample.yaw_rate_rad_s)
        changed = replace(
            inputs,
            forces=sample.forces if sample.forces is not None else inputs.forces,
            pose_W=pose,
            yaw_rate_rad_s=sample.yaw_rate_rad_s if turning else inputs.yaw_rate_rad_s,
        )
        redo = [changed, *(inputs for _, inputs in ticks[place + 1 :])]
        self.state = ticks[place][0]
        for _ in range(len(ticks) - place):
            self._ticks.pop()
        estimate = None
        for inputs in redo:
            estimate = self.step(inputs)
        return estimate


def _adds(inputs: OdometryInputs, sample: LateSample) -> bool:
    """Whether a sample holds something that this tick does not know yet."""
    forces = sample.forces is not None and (
        inputs.forces is None or inputs.forces.t_ns < sample.forces.t_ns
    )
    turning = np.isfinite(sample.yaw_rate_rad_s) and not np.isfinite(inputs.yaw_rate_rad_s)
    return bool(forces or turning or (sample.pose_W is not None and inputs.pose_W is None))
