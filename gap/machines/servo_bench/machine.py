"""The nominal servos of a trial of kind ``servo_bench``, read from the machine's file."""

from collections.abc import Mapping
from dataclasses import dataclass

from gap.machines.servo_bench.kernel import ServoNumbers
from model.errors import ConfigError, GapError, RecordError
from model.parameters.tables import parse_table
from model.parameters.toml_table import Table
from record.trial.trial import Trial

# Groups of a joint's table; keys are fields of ``ServoNumbers``, but for those of the load.
GROUPS = {
    "controller": ("kp_duty_per_rad", "kd", "ki", "duty_limit", "delay_s"),
    "load": ("mass_kg", "length_m"),
    "friction": ("coulomb_nm", "viscous_nm_s"),
}
MOTOR_KEYS = ("supply_v", "torque_constant_nm_a", "resistance_ohm", "armature_kg_m2")


@dataclass(frozen=True, slots=True)
class ServoJoint:
    """One nominal servo; an ideal one has no motor data: its shaft goes where it is commanded."""

    name: str
    ideal: bool
    numbers: ServoNumbers


def nominal_servos(trial: Trial) -> tuple[ServoJoint, ...]:
    """Read the servos that a trial names, in the order of its joints or of the machine's file.

    Numbers of [joint.NAME.controller] that the log has as constants of its own (``kp_duty_per_rad``, one a
    joint) are taken from there.

    Raises:
        GapError: The machine's file does not describe servos, or not those of the trial.
    """
    header = trial.header
    try:
        tables = parse_table(header.robot_text).maybe_table("joint")
        names = trial.joints or tables.names()
        unknown = [name for name in names if tables.names() and name not in tables.names()]
        if unknown:
            raise GapError(
                f"the machine's file has joints {', '.join(tables.names())}, the log has "
                f"{', '.join(names)}: give the file of these servos, or map the columns to its joints"
            )
        logged = {key: header.constant(key) for key in GROUPS["controller"]}
        joints = tuple(
            _joint(name, tables.maybe_table(name), {k: v[at] for k, v in logged.items() if v})
            for at, name in enumerate(names)
        )
    except (ConfigError, RecordError) as error:
        raise GapError(f"the machine's file cannot be used: {error}") from error
    if not joints:
        raise GapError("the trial has no joints; name its columns command_NAME_rad, shaft_NAME_rad")
    return joints


def _joint(name: str, table: Table, logged: Mapping[str, float]) -> ServoJoint:
    numbers: dict[str, float] = {}
    for group, keys in GROUPS.items():
        entries = table.maybe_table(group)
        numbers |= {key: entries.number(key, minimum=0.0) for key in keys if entries.has(key)}
        entries.done()
    numbers |= logged
    motor = table.maybe_table("motor")
    if motor.names():
        numbers |= {key: motor.number(key, above=0.0) for key in MOTOR_KEYS}
        motor.done()
    table.done()
    mass, length = numbers.pop("mass_kg", 0.0), numbers.pop("length_m", 0.0)
    numbers["break_nm"] = numbers.get("coulomb_nm", 0.0)
    servo = ServoNumbers(load_kg_m=mass * length, load_kg_m2=mass * length**2, **numbers)
    return ServoJoint(name, not motor.names(), servo)
