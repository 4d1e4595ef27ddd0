"""The nominal servos of a trial of kind ``servo_bench``, read from the machine's file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import tomlkit

from gap.interfaces import Cause, Effect
from gap.machines.servo_bench.catalogue import BY_NAME, BenchEffect, added
from gap.machines.servo_bench.kernel import ServoNumbers
from model.effects.causes import joint_by_joint
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
        raise GapError(
            f"the machine's file cannot be used: {error} (see docs/servo_bench.md)"
        ) from error
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
    effects = table.maybe_table("effects")
    causes = [_effect_of(effects.table(one), one) for one in effects.names()]
    table.done()
    mass, length = numbers.pop("mass_kg", 0.0), numbers.pop("length_m", 0.0)
    numbers["break_nm"] = numbers.get("coulomb_nm", 0.0)
    servo = ServoNumbers(load_kg_m=mass * length, load_kg_m2=mass * length**2, **numbers)
    for effect, values in causes:
        servo = added(servo, effect, values)
    return ServoJoint(name, not motor.names(), servo)


def _effect_of(table: Table, name: str) -> tuple[BenchEffect, tuple[float, ...]]:
    """Read one effect of [joint.NAME.effects], which ``gap apply`` writes."""
    if name not in BY_NAME:
        raise ConfigError(table.name(name), f"is no effect; there are {', '.join(BY_NAME)}")
    effect = BY_NAME[name]
    values = tuple(
        table.number(p.name, minimum=p.lower, maximum=p.upper) for p in effect.parameters
    )
    table.done()
    return effect, values


def with_causes(text: str, causes: Sequence[Cause], effects: Sequence[Effect]) -> str:
    """Write causes into a machine's file, in [joint.NAME.effects.EFFECT]; all else stays.

    An effect that is there already gets both: ratios are multiplied, what is added is added up.

    Raises:
        GapError: The file has no such joint.
    """
    known = {effect.name: effect for effect in effects}
    document = tomlkit.parse(text)
    joints = document.setdefault("joint", tomlkit.table(is_super_table=True))
    for cause in (one for c in causes for one in joint_by_joint(c, known[c.effect])):
        for joint in cause.joints:
            if joint not in joints:
                raise GapError(f"the machine's file has no [joint.{joint}]; add it")
            own = joints[joint].setdefault("effects", tomlkit.table(is_super_table=True))
            effect = BY_NAME[cause.effect]
            before = own.get(cause.effect, {})
            both = tomlkit.table()
            for p, value, (_, how) in zip(
                effect.parameters, cause.values, effect.places, strict=True
            ):
                old = float(before.get(p.name, p.neutral))
                both[p.name] = _together(how, old, value)
            own[cause.effect] = both
    return tomlkit.dumps(document)


def _together(how: str, old: float, value: float) -> float:
    """One number for two of the same effect."""
    return {"+": old + value, "*": old * value, "<": min(old, value)}.get(how, value)
