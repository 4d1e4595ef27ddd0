"""What a trial says beside its samples: gait, conditions, rates, noise, and which machine it was."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from model.errors import RecordError
from model.parameters.tables import CHAIN
from model.values.machine_names import PART_NAME, MachineNames

LEGGED, SERVO_BENCH, SLIDING_BODY, MJCF = "legged", "servo_bench", "sliding_body", "mjcf"
# Machine's files that are no TOML of ours, by their suffix.
KIND_OF_SUFFIX = {".xml": MJCF, ".urdf": MJCF}
_JOINT_OF_COLUMN = re.compile(
    r"(?:command_(.+)_rad|shaft_(.+?)_rad(?:_s)?|current_(.+)_a|voltage_(.+)_v|temperature_(.+)_c"
    r"|pwm_(.+)|torque_(.+)_nm|(?:foot_(.+)_[xyz]_m)|(?:force_(.+)_[xyz]_n))"
)
_LEG_OF_COLUMN = re.compile(r"foot_(.+)_[xyz]_m|force_(.+)_[xyz]_n")
_KIND = re.compile(r"[a-z]\w*")
Condition = str | float


@dataclass(frozen=True, slots=True)
class TrialNoise:
    """One standard deviation of each sensor's noise; NaN where it is not known.

    Attributes:
        force_n: Each axis of a foot's force.
        body_position_m: Each axis of the body's position.
        body_angle_rad: Each angle of the body.
        shaft_rad: Shaft angle.
        foot_position_m: Each axis of a foot's position.
    """

    force_n: float = math.nan
    body_position_m: float = math.nan
    body_angle_rad: float = math.nan
    shaft_rad: float = math.nan
    foot_position_m: float = math.nan


@dataclass(frozen=True, slots=True)
class TrialHeader:
    """Everything of a trial that is no sample.

    Attributes:
        kind: Kind of machine, ``legged`` or the name of another one of ``gap.machine_kinds``.
        joints: Names of joints, in the order of the machine's file.
        gait: Name of the gait, as in the robot file; empty where there is none.
        frequency_hz: Cycles a second; NaN if not known.
        sample_rate_hz: Samples a second; NaN if not known.
        notes: Words.
        noise: Noise of the sensors.
        robot_file: Name of the machine's file, relative to the trial; empty if there is none.
        robot_text: What it says.
        legs: Names of legs that are apart from the joints; empty where a legged robot's are called as its
            joints, and for a machine without legs.
        derived: What was not measured but worked out from other columns, in words.
        conditions: Under which the run was made, such as ``("trajectory", "lift_and_drop")``: a table of
            the user's own.
        constants: Numbers of the log that are no samples, such as the gain of each joint: name and values,
            one a joint in their order, or one.
        drive: The table [drive] as TOML: how the joints are driven, for machines whose file does not say.
        folder: Where the trial's file lies, so that the machine's can be opened; empty for one in memory.
    """

    kind: str
    joints: tuple[str, ...]
    gait: str = ""
    frequency_hz: float = math.nan
    sample_rate_hz: float = math.nan
    notes: str = ""
    noise: TrialNoise = TrialNoise()
    robot_file: str = ""
    robot_text: str = ""
    legs: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()
    conditions: tuple[tuple[str, Condition], ...] = ()
    constants: tuple[tuple[str, tuple[float, ...]], ...] = ()
    drive: str = ""
    folder: str = field(default="", compare=False, repr=False)

    @property
    def names(self) -> MachineNames:
        """Names of joints and legs."""
        called_as_joints = self.kind == LEGGED and not self.legs
        return MachineNames(self.joints, self.joints if called_as_joints else self.legs)

    def condition(self, key: str) -> Condition | None:
        """Return a condition of the run, its gait and frequency among them; None if it is not known."""
        known: dict[str, Condition] = dict(self.conditions)
        if self.gait:
            known["gait"] = self.gait
        if not math.isnan(self.frequency_hz):
            known["frequency_hz"] = self.frequency_hz
        return known.get(key)

    def constant(self, name: str) -> tuple[float, ...]:
        """Return a constant of the log, one value a joint; empty if there is none.

        Raises:
            RecordError: It has neither one value nor one a joint.
        """
        values = dict(self.constants).get(name, ())
        if len(values) == 1:
            return values * len(self.joints)
        if values and len(values) != len(self.joints):
            raise RecordError(
                f"constants.{name} has {len(values)} values for {len(self.joints)} joints; give one, or "
                "one a joint"
            )
        return values


def check_joints(joints: tuple[str, ...], path: Path) -> tuple[str, ...]:
    """Return names of joints that are fit to stand in names of columns.

    Raises:
        RecordError: One is no name, or two are the same.
    """
    for name in joints:
        if not PART_NAME.fullmatch(name):
            raise RecordError(
                f"{path}: {name!r} is no name of a leg or joint; use letters, digits and _"
            )
    if len(set(joints)) != len(joints):
        raise RecordError(f"{path}: legs must differ from each other, not {', '.join(joints)}")
    return joints


def kind_of(robot: Mapping[str, Any], path: Path) -> str:
    """Return the kind of machine that its file says; a hexapod's says none.

    Raises:
        RecordError: It is no name. Whether there is such a kind is known where it is diagnosed.
    """
    kind = robot.get("kind", LEGGED)
    if not isinstance(kind, str) or not _KIND.fullmatch(kind):
        raise RecordError(
            f"{path}: kind must be the name of a kind of machine, such as {SERVO_BENCH}, not {kind!r}"
        )
    return kind


def joints_of(robot: Mapping[str, Any], columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the joints that a machine's file names, or else those that the columns name."""
    legs, joints = robot.get("legs"), robot.get("joint")
    if chain := _chain_of(robot):
        return tuple(str(name) for name in chain["joints"])
    if isinstance(legs, Mapping) and isinstance(legs.get("order"), list):
        return tuple(str(name) for name in legs["order"])
    if isinstance(joints, Mapping):
        return tuple(joints)
    if robot.get("kind") == SLIDING_BODY:
        return ()
    matches = (_JOINT_OF_COLUMN.fullmatch(name) for name in columns)
    names = (next(g for g in match.groups() if g) for match in matches if match)
    return tuple(dict.fromkeys(names))


def legs_of(robot: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the legs of a machine whose joints have names of their own; none of any other."""
    legs = robot.get("legs")
    if not _chain_of(robot) or not isinstance(legs, Mapping):
        return ()
    return tuple(str(name) for name in legs.get("order", ()))


def _chain_of(robot: Mapping[str, Any]) -> Mapping[str, Any]:
    """The table [leg.chain] of a machine whose legs have several joints; empty without."""
    leg = robot.get("leg")
    chain = leg.get(CHAIN) if isinstance(leg, Mapping) else None
    return chain if isinstance(chain, Mapping) and isinstance(chain.get("joints"), list) else {}


def without_legs(columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the columns that are of no leg: those that name the joints of a machine that is not legged."""
    return tuple(name for name in columns if not _LEG_OF_COLUMN.fullmatch(name))


def legs_named(columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the legs that columns name, of a machine whose file names none."""
    matches = (_LEG_OF_COLUMN.fullmatch(name) for name in columns)
    return tuple(dict.fromkeys(next(g for g in one.groups() if g) for one in matches if one))
