"""The estimator's stage over many ticks that are there already: in blocks where it can be, else one by one.

A block holds ticks in a row of a fast loop, with shafts and forces alone: no pose, no IMU, no effects. What
comes out is what the stage makes of them tick by tick, to the bit.
"""

from functools import cached_property

import numpy as np

from model.estimator.block.inputs import BlockInputs
from model.estimator.block.run import BlockEstimator, EstimatedBlock
from model.estimator.filter import Estimator
from model.motion.shaft_speed import SLOW_S, ShaftSpeeds, no_error
from model.values.arrays import part_of
from model.values.estimate import Estimate, OdometryInputs
from model.values.legs import FootMotion
from model.values.tick_rows import SensedRows
from robot.control.estimator_stage import EstimatorStage, StageMemory

FEWEST = 8  # ticks: fewer take longer as a block


class StageBlock:
    """What the stage makes of ticks in a row.

    Args:
        before: What it remembered.
        block: Of the filter.
        ticks: The ticks.
    """

    def __init__(self, before: StageMemory, block: EstimatedBlock, ticks: SensedRows) -> None:
        self._before, self.block, self._ticks = before, block, ticks

    def __len__(self) -> int:
        return len(self._ticks)

    def estimate(self, k: int) -> Estimate:
        """Return the estimate of tick k."""
        return self.block.estimate(k)

    def memory(self, k: int) -> StageMemory:
        """Return what the stage remembers after tick k."""
        joints = self._ticks.joints.state(k)
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
        self, memory: StageMemory, ticks: SensedRows, feet: FootMotion, begin: int
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
        count = _usual(memory, ticks, begin)
        if count < FEWEST:
            return None
        part = slice(begin, begin + count)
        ticks = part_of(ticks, part)
        forces = ticks.forces
        position_m, velocity_m_s = feet.position_m[part], feet.velocity_m_s[part]
        rates = ticks.joints.rate_rad_s
        shafts = rates if rates.shape[1] == self._legs else None  # a shaft a leg

        def of_tick(k: int) -> OdometryInputs:
            return OdometryInputs(
                int(ticks.t_ns[k]), FootMotion(position_m[k], velocity_m_s[k]), forces.forces(k),
                shaft_rad_s=rates[k] if shafts is not None else None,
            )  # fmt: skip

        inputs = BlockInputs(
            ticks.t_ns, position_m, velocity_m_s, forces.t_ns, forces.force_n, forces.valid, shafts,
            of_tick,
        )  # fmt: skip
        return StageBlock(memory, self._blocks.advance(memory.estimator, inputs), ticks)


def _usual(memory: StageMemory, ticks: SensedRows, begin: int) -> int:
    """How many ticks, from one on, a block can hold."""
    if memory.speeds is None:
        return 0
    # with shafts and forces alone, and no speed that is corrected
    dt_s = np.diff(ticks.joints.t_ns[begin:], prepend=memory.speeds.t_ns) * 1e-9
    alone = [
        not (poses or imu)
        for poses, imu in zip(ticks.poses[begin:], ticks.imu[begin:], strict=True)
    ]
    usual = (dt_s != 0.0) & (dt_s < SLOW_S) & alone
    return len(usual) if usual.all() else int(np.argmin(usual))
