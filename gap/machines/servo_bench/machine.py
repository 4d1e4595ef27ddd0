"""The nominal servos of a trial of kind ``servo_bench``, read from the machine's file."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from model.errors import GapError
from record.trial.trial import Trial

MOTOR_KEYS = ("supply_v", "torque_constant_nm_a", "resistance_ohm", "armature_kg_m2")


@dataclass(frozen=True, slots=True)
class ServoJoint:
    """One nominal servo.

    Attributes:
        name: Its joint.
        ideal: True where no motor data are given: the shaft goes where it is told.
        kp_duty_per_rad: Position gain, duty per rad of error.
        kd: Duty per rad/s of falling error.
        ki: Duty per rad s.
        duty_limit: Largest duty, 0 to 1.
        delay_s: Delay of commands that the nominal servo has.
        supply_v: Supply.
        torque_constant_nm_a: Torque at the shaft per ampere, which is also volts per rad/s.
        resistance_ohm: Winding.
        armature_kg_m2: Rotor's inertia at the shaft.
        mass_kg: Load at the end of the pendulum; 0 for none.
        length_m: Length of the pendulum; angle 0 hangs down.
        coulomb_nm: Dry friction.
        viscous_nm_s: Viscous friction.
    """

    name: str
    ideal: bool
    kp_duty_per_rad: float = 4.0
    kd: float = 0.0
    ki: float = 0.0
    duty_limit: float = 1.0
    delay_s: float = 0.0
    supply_v: float = 12.0
    torque_constant_nm_a: float = 1.0
    resistance_ohm: float = 1.0
    armature_kg_m2: float = 0.01
    mass_kg: float = 0.0
    length_m: float = 0.0
    coulomb_nm: float = 0.0
    viscous_nm_s: float = 0.0


@dataclass(frozen=True, slots=True)
class ServoMachine:
    """The nominal servos, in the order of the machine's file."""

    joints: tuple[ServoJoint, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(joint.name for joint in self.joints)


def servo_machine(trial: Trial) -> ServoMachine:
    """Read the servos that a trial names.

    Raises:
        GapError: The machine's file does not describe servos.
    """
    data = tomllib.loads(trial.header.robot_text)
    tables = data.get("joint", {})
    if not isinstance(tables, Mapping):
        raise GapError("joint of the machine's file must hold one table a servo: [joint.NAME]")
    names = trial.joints or tuple(tables)
    if not names:
        raise GapError("the trial has no joints; name its columns command_NAME_rad, shaft_NAME_rad")
    return ServoMachine(tuple(_joint(name, tables.get(name, {})) for name in names))


def _joint(name: str, table: Mapping[str, Any]) -> ServoJoint:
    known = {
        "controller": ("kp_duty_per_rad", "kd", "ki", "duty_limit", "delay_s"),
        "motor": MOTOR_KEYS,
        "load": ("mass_kg", "length_m"),
        "friction": ("coulomb_nm", "viscous_nm_s"),
    }
    numbers: dict[str, float] = {}
    for group, entries in table.items():
        if group not in known or not isinstance(entries, Mapping):
            raise GapError(f"joint.{name}.{group} is not known; groups are {', '.join(known)}")
        for key, value in entries.items():
            if key not in known[group]:
                raise GapError(
                    f"joint.{name}.{group}.{key} is not known; known are {', '.join(known[group])}"
                )
            if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
                raise GapError(f"joint.{name}.{group}.{key} must be a number from 0, not {value!r}")
            numbers[key] = float(value)
    motor = table.get("motor", {})
    missing = [key for key in MOTOR_KEYS if key not in motor]
    if motor and missing:
        raise GapError(
            f"joint.{name}.motor lacks {', '.join(missing)}; give all or leave motor out"
        )
    for key in MOTOR_KEYS:
        if motor and not numbers[key] > 0:
            raise GapError(f"joint.{name}.motor.{key} must be above 0")
    return ServoJoint(name, ideal=not motor, **numbers)
