"""The estimator's stage over many ticks that are there already: in blocks where it can be, else one by one.

A block holds ticks in a row of a fast loop, with shafts and forces alone: no pose, no IMU, no effects. What
comes out is what the stage makes of them tick by tick, to the bit.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import islice

import numpy as np

from model.estimator.block.inputs import BlockInputs
from model.estimator.block.run import BlockEstimator, EstimatedBlock
from model.estimator.filter import Estimator
from model.motion.shaft_speed import SLOW_S, ShaftSpeeds, no_error
from model.values.estimate import Estimate, OdometryInputs
from model.values.legs import FootMotion
from model.values.tick import SensedTick
from robot.control.estimator_stage import EstimatorStage, StageMemory

FEWEST = 8  # ticks: fewer take longer as a block


class StageBlock:
    """What the stage makes of ticks in a row.

    Args:
        before: What it remembered.
        block: Of the filter.
        ticks: The ticks.
    """

    def __init__(
        self, before: StageMemory, block: EstimatedBlock, ticks: Sequence[SensedTick]
    ) -> None:
        self._before, self.block, self._ticks = before, block, ticks

    def __len__(self) -> int:
        return len(self._ticks)

    def estimate(self, k: int) -> Estimate:
        """Return the estimate of tick k."""
        return self.block.estimate(k)

    def memory(self, k: int) -> StageMemory:
        """Return what the stage remembers after tick k."""
        joints = self._ticks[k].joints
        speeds = ShaftSpeeds(
            joints.t_ns, joints.angle_rad, joints.rate_rad_s, no_error(len(joints.angle_rad))
        )
        return StageMemory(self.block.memory(k + 1), self._before.alignment, None, speeds)


def block_stage(stage: EstimatorStage) -> "BlockStage | None":
    """Return the stage over blocks; None where effects of the robot file are in it."""
    estimator = stage.filter_alone
    return BlockStage(estimator, stage.memory_s) if estimator is not None else None


class BlockStage:
    """The stage over blocks.

    Args:
        estimator: Its filter.
        memory_s: How late a sample may be [s].
    """

    def __init__(self, estimator: Estimator, memory_s: float) -> None:
        self._estimator, self._memory_s = estimator, memory_s
        self._legs = estimator.legs

    @cached_property
    def _blocks(self) -> BlockEstimator:
        return BlockEstimator(self._estimator, self._memory_s)

    def advance(
        self, memory: StageMemory, ticks: Sequence[SensedTick], feet: FootMotion, begin: int
    ) -> StageBlock | None:
        """Advance by as many ticks, from one on, as a block can hold.

        Args:
            memory: What the stage remembered before it.
            ticks: The ticks.
            feet: Unloaded feet in all of them, with the servos' own speeds, (T, N, 3) each.
            begin: Which tick.

        Returns:
            None if there are too few for a block.
        """
        count = _usual(memory, islice(ticks, begin, None))
        if count < FEWEST:
            return None
        part = slice(begin, begin + count)
        ticks, position_m, velocity_m_s = (
            ticks[part],
            feet.position_m[part],
            feet.velocity_m_s[part],
        )
        rates = np.array([tick.joints.rate_rad_s for tick in ticks])
        shafts = rates if rates.shape[1] == self._legs else None  # a shaft a leg

        def of_tick(k: int) -> OdometryInputs:
            return OdometryInputs(
                ticks[k].t_ns, FootMotion(position_m[k], velocity_m_s[k]), ticks[k].forces,
                shaft_rad_s=ticks[k].joints.rate_rad_s if shafts is not None else None,
            )  # fmt: skip

        forces = [tick.forces for tick in ticks]
        inputs = BlockInputs(
            np.array([tick.t_ns for tick in ticks]), position_m, velocity_m_s,
            np.array([one.t_ns for one in forces]), np.array([one.force_n for one in forces]),
            np.array([one.valid for one in forces]), shafts, of_tick,
        )  # fmt: skip
        return StageBlock(memory, self._blocks.advance(memory.estimator, inputs), ticks)


def _usual(memory: StageMemory, ticks: Iterable[SensedTick]) -> int:
    """How many ticks, from the first on, a block can hold; no more are looked at."""
    if memory.speeds is None:
        return 0
    count, before_ns = 0, memory.speeds.t_ns
    for tick in ticks:
        dt_s = (tick.joints.t_ns - before_ns) * 1e-9
        # with shafts and forces alone, and no speed that is corrected
        if tick.poses or tick.imu or dt_s == 0.0 or dt_s >= SLOW_S:
            break
        count, before_ns = count + 1, tick.joints.t_ns
    return count
