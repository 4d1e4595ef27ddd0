"""The estimator over ticks that are there already, such as those of a log."""

from collections.abc import Iterator
from typing import NamedTuple

from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.kinematics.one_shaft import OneShaftKinematics
from model.values.estimate import Estimate
from model.values.legs import FootMotion
from model.values.tick import SensedTick
from model.values.tick_rows import SensedRows
from robot.config.robot_file import RobotConfig
from robot.control.estimator_block import StageBlock, block_stage
from robot.control.estimator_stage import StageMemory, estimator_stage


class SingleTick(NamedTuple):
    """What the estimator makes of a tick by itself: its memory before and after, and what it says."""

    before: StageMemory
    after: StageMemory
    estimate: Estimate


class TickEstimator:
    """The stage over ticks that are there already, such as those of a log, one after the other.

    Args:
        config: Robot file.
        blocks: Whether to go through many ticks in blocks. That is faster, but has machine code of its own,
            which pays for a long log.
    """

    def __init__(self, config: RobotConfig, *, blocks: bool = False) -> None:
        self._names = config.parameters.names
        self._sizes = len(self._names.legs), len(self._names.joints)
        self._kinematics = leg_kinematics(config.parameters)
        self._stage = estimator_stage(config, self._kinematics)
        self._blocks = block_stage(self._stage) if blocks else None
        self.memory = self._stage.initial()

    def through(self, ticks: SensedRows) -> Iterator[StageBlock | SingleTick]:
        """Advance by ticks in a row, in blocks where that can be.

        Args:
            ticks: The ticks.

        Yields:
            What the estimator makes of them, block by block or tick by tick.

        Raises:
            ConfigError: The robot has other legs or joints than the ticks.
        """
        if len(ticks) and ticks.sizes != self._sizes:
            self._check(*ticks.sizes)
        feet = None
        if isinstance(self._kinematics, OneShaftKinematics):  # the same as of each tick
            feet = self._kinematics.feet(ticks.joints.angle_rad, ticks.joints.rate_rad_s)
        at = 0
        while at < len(ticks):
            block = None
            if feet is not None and self._blocks is not None:
                block = self._blocks.advance(self.memory, ticks, feet, at)
            if block is not None:
                self.memory = block.memory(len(block) - 1)
                yield block
                at += len(block)
                continue
            known = None
            if feet is not None:
                known = FootMotion(feet.position_m[at], feet.velocity_m_s[at])
            before = self.memory
            estimate = self.step(ticks.tick(at), known)
            yield SingleTick(before, self.memory, estimate)
            at += 1

    def step(self, tick: SensedTick, feet: FootMotion | None = None) -> Estimate:
        """Advance by a tick.

        Args:
            tick: The tick.
            feet: Its feet, with the servos' own speeds, if they are known already.

        Raises:
            ConfigError: The robot has other legs or joints than the tick.
        """
        sizes = len(tick.forces.force_n), len(tick.joints.angle_rad)
        if sizes != self._sizes:
            self._check(*sizes)
        self.memory, estimate = self._stage.step(
            self.memory, tick.t_ns, tick.joints, tick.forces, tick.poses, tick.imu, feet
        )
        return estimate

    def _check(self, legs: int, joints: int) -> None:
        names = self._names
        if legs == joints == len(names.joints) > len(names.legs):
            words = f"has {len(names.legs)} legs, and the log was imported without it, so that each joint"
            hint = "passes for a leg; name it in the map, [trial] robot, and import again"
            raise ConfigError("--robot", f"{words} {hint}")
        for word, own, there in (("legs", names.legs, legs), ("joints", names.joints, joints)):
            if len(own) != there:
                words = f"has {len(own)} {word}, the log {there}; choose another file"
                raise ConfigError("--robot", words)
