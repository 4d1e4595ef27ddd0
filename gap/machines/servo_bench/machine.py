"""The nominal servos of a trial of kind ``servo_bench``, read from the machine's file."""

from dataclasses import dataclass

from model.errors import ConfigError, GapError
from model.parameters.tables import parse_table
from model.parameters.toml_table import Table
from record.trial.trial import Trial

# Groups of a joint's table, whose keys are fields of ``ServoJoint``.
GROUPS = {
    "controller": ("kp_duty_per_rad", "kd", "ki", "duty_limit", "delay_s"),
    "load": ("mass_kg", "length_m"),
    "friction": ("coulomb_nm", "viscous_nm_s"),
}
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
    try:
        tables = parse_table(trial.header.robot_text).maybe_table("joint")
        names = trial.joints or tables.names()
        joints = tuple(_joint(name, tables.maybe_table(name)) for name in names)
    except ConfigError as error:
        raise GapError(f"the machine's file cannot be used: {error}") from error
    if not joints:
        raise GapError("the trial has no joints; name its columns command_NAME_rad, shaft_NAME_rad")
    return ServoMachine(joints)


def _joint(name: str, table: Table) -> ServoJoint:
    numbers: dict[str, float] = {}
    for group, keys in GROUPS.items():
        entries = table.maybe_table(group)
        numbers |= {key: entries.number(key, minimum=0.0) for key in keys if entries.has(key)}
        entries.done()
    motor = table.maybe_table("motor")
    if motor.names():
        numbers |= {key: motor.number(key, above=0.0) for key in MOTOR_KEYS}
        motor.done()
    table.done()
    return ServoJoint(name, ideal=not motor.names(), **numbers)
