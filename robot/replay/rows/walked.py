"""What the step makes of ticks of a walk in which nothing happens, as arrays: a row a tick."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaits.plan import GoalRows
from model.quasistatic.frame import FrameRows
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.faults import StopReason
from model.values.input_rows import InputRows
from model.values.legs import FootMotion, JointCommand
from model.values.tick import DeadReckoning, Inputs, Mode, Tick
from model.values.tick_rows import ForceRows, JointRows, SensedRows
from robot.control.body_watch import NOWHERE, BodyMemory, Travel
from robot.control.modes import Phase
from robot.control.recovery import RecoveryPlan
from robot.control.safety import Allowed, ServoVerdict
from robot.control.state import Command, ControllerState, Decision, Estimates, Senses


@dataclass(frozen=True, slots=True, eq=False)
class WalkRows:
    """Outputs of T ticks.

    Attributes:
        t_ns: Times of the ticks, (T,).
        joints: Calibrated shafts.
        forces: Latest measured foot forces.
        feet: Unloaded feet, (T, N, 3).
        contact: The model's answers; each frame has one.
        position_m: Dead reckoning's, (T, 2).
        yaw_rad: Dead reckoning's, (T,).
        goals: What the plan asks for, and the gate lets through.
    """

    t_ns: IntArray
    joints: JointRows
    forces: ForceRows
    feet: FootMotion
    contact: FrameRows
    position_m: FloatArray
    yaw_rad: FloatArray
    goals: GoalRows


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    """What is remembered after the last of the ticks, beside the outputs.

    Attributes:
        phase: Mode and plan, the same in all of them.
        last: The last command, dated when the servos had it.
        times_ns: Times of the latest shaft angles, (W,).
        angles_rad: Latest shaft angles, (W, N).
        travels: Of each leg.
    """

    phase: Phase
    last: JointCommand
    times_ns: IntArray
    angles_rad: FloatArray
    travels: tuple[Travel, ...]


class WalkedRows:
    """Ticks of a walk in a row: their outputs, and the state after them.

    Args:
        before: The state before them.
        inputs: The inputs of the block that they are in.
        begin: Which of these is their first.
        rows: Their outputs.
        ending: What is remembered.
    """

    def __init__(
        self, before: ControllerState, inputs: InputRows, begin: int, rows: WalkRows, ending: Ending
    ) -> None:
        self._before, self._inputs, self._begin = before, inputs, begin
        self.rows, self._ending = rows, ending

    def __len__(self) -> int:
        return len(self.rows.t_ns)

    def column(self, name: str) -> NDArray[Any]:
        """Return an output in numbers, (T, ...); its names are places in a ``Tick``."""
        if name in _CONSTANT:
            return np.full(len(self), _CONSTANT[name])
        return _COLUMNS[name](self.rows)

    def texts(self, name: str) -> list[str]:
        """Return a text of each: reasons why there is no answer."""
        del name
        return [""] * len(self)

    @property
    def sensed(self) -> SensedRows:
        """What was sensed in them."""
        span = slice(self._begin, self._begin + len(self))
        poses, imu = self._inputs.poses[span], self._inputs.imu[span]
        return SensedRows(self.rows.t_ns, self.rows.joints, self.rows.forces, poses, imu)

    def tick(self, k: int, inputs: Inputs) -> Tick:
        """Return tick k, of these inputs."""
        rows, command = self.rows, self._command(k)
        return Tick(
            int(rows.t_ns[k]), self._before.index + k, Mode.WALK, StopReason.NONE, inputs,
            rows.joints.state(k), rows.forces.forces(k), float(rows.goals.phase[k]), command,
            command, FootMotion(rows.feet.position_m[k], rows.feet.velocity_m_s[k]),
            rows.contact.solution(k), self._dead_reckoning(k), (), None,
        )  # fmt: skip

    def _command(self, k: int) -> JointCommand:
        goals = self.rows.goals
        return JointCommand(
            int(self.rows.t_ns[k]), goals.angle_rad[k], goals.rate_rad_s[k], torque=True
        )

    def _dead_reckoning(self, k: int) -> DeadReckoning:
        rows = self.rows
        velocity_B = readonly(rows.contact.numbers[k, 3:6].copy())  # noqa: N806
        return DeadReckoning(
            int(rows.t_ns[k]), rows.position_m[k], float(rows.yaw_rad[k]), velocity_B, valid=True
        )

    @cached_property
    def state(self) -> ControllerState:
        """The state after the last of them."""
        before, ending, rows, k = self._before, self._ending, self.rows, len(self) - 1
        joints, forces, command = rows.joints.state(k), rows.forces.forces(k), self._command(k)
        memory = before.decision.recovery.memory
        senses = Senses(
            self._inputs.servos.readings(self._begin + k), joints, forces, memory.down, ending.last,
            ending.times_ns, ending.angles_rad, before.senses.began_ns,
        )  # fmt: skip
        estimates = Estimates(
            FootMotion(rows.feet.position_m[k], rows.feet.velocity_m_s[k]), rows.contact.solution(k),
            forces, self._dead_reckoning(k), None, before.estimates.estimator, (),
        )  # fmt: skip
        decision = Decision(
            ending.phase, RecoveryPlan(memory), ServoVerdict.sound(len(joints.valid)),
            BodyMemory(joints.t_ns, ending.travels, 0.0, 0.0, NOWHERE), 0, (),
        )  # fmt: skip
        return ControllerState(
            before.index + k + 1, senses, estimates, decision,
            Command(command, Allowed(command), 0, ()),
        )  # fmt: skip


_CONSTANT: Mapping[str, int | bool] = MappingProxyType({
    "mode": Mode.WALK.value,
    "stop_reason": StopReason.NONE.value,
    "wished.torque": True,
    "sent.torque": True,
    "contact.support.converged": True,
    "contact.traction.valid": True,
    "dead_reckoning.valid": True,
})  # fmt: skip
_COMMAND: Mapping[str, Callable[[WalkRows], NDArray[Any]]] = MappingProxyType({
    "t_ns": lambda rows: rows.t_ns,
    "angle_rad": lambda rows: rows.goals.angle_rad,
    "rate_rad_s": lambda rows: rows.goals.rate_rad_s,
})  # fmt: skip
_CONTACT: Mapping[str, Callable[[FrameRows], NDArray[Any]]] = MappingProxyType({
    "support.slope_x": lambda rows: rows.pose[:, 0],
    "support.slope_y": lambda rows: rows.pose[:, 1],
    "support.height_m": lambda rows: rows.pose[:, 2],
    "support.load_n": lambda rows: rows.parts[1],
    "support.contact": lambda rows: rows.loaded,
    "support.switches": lambda rows: rows.verdicts[:, 0],
    "traction.velocity_B": lambda rows: rows.parts[0],
    "traction.slip_B": lambda rows: rows.parts[2],
    "traction.force_B": lambda rows: rows.parts[3],
})  # fmt: skip


def _joints(name: str) -> Callable[[WalkRows], NDArray[Any]]:
    return lambda rows: getattr(rows.joints, name)


def _forces(name: str) -> Callable[[WalkRows], NDArray[Any]]:
    return lambda rows: getattr(rows.forces, name)


def _contact(take: Callable[[FrameRows], NDArray[Any]]) -> Callable[[WalkRows], NDArray[Any]]:
    return lambda rows: take(rows.contact)


_COLUMNS: Mapping[str, Callable[[WalkRows], NDArray[Any]]] = MappingProxyType({
    **{f"joints.{name}": _joints(name) for name in JointRows.__slots__},
    **{f"forces.{name}": _forces(name) for name in ForceRows.__slots__},
    **{f"wished.{name}": take for name, take in _COMMAND.items()},
    **{f"sent.{name}": take for name, take in _COMMAND.items()},
    **{f"contact.{name}": _contact(take) for name, take in _CONTACT.items()},
    "gait_phase": lambda rows: rows.goals.phase,
    "feet.position_m": lambda rows: rows.feet.position_m,
    "feet.velocity_m_s": lambda rows: rows.feet.velocity_m_s,
    "dead_reckoning.t_ns": lambda rows: rows.t_ns,
    "dead_reckoning.position_m": lambda rows: rows.position_m,
    "dead_reckoning.yaw_rad": lambda rows: rows.yaw_rad,
    "dead_reckoning.velocity_B": lambda rows: rows.contact.parts[0],
})  # fmt: skip
