"""How joints are driven: the table [drive] beside a log, in the units of the field, and its law of torque.

``position``: a PD loop in N m/rad. ``firmware``: a Dynamixel's loop, duty by the angle's error onto a DC
motor, with the numbers of ``servo_bench``. ``torque`` and ``current``: what was logged of them.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from drivers.dynamixel.units import DUTY_FULL, TICKS_PER_TURN
from gap.machines.mujoco.rigid_model import Mounting
from gap.machines.servo_bench.kernel import UNLIMITED_RAD_S
from model.errors import ConfigError, GapError
from model.parameters.tables import parse_table
from model.parameters.toml_table import Table
from model.values.arrays import FloatArray
from record.trial.trial import Trial

POSITION, FIRMWARE, TORQUE, CURRENT = "position", "firmware", "torque", "current"
KINDS = (POSITION, FIRMWARE, TORQUE, CURRENT)
P_GAIN_DIVISOR = 128.0  # e-manual, "Position PID Gain"
# Keys of [drive] to the numbers of a joint that they set.
COMMON = {
    "armature_kg_m2": "armature_kg_m2",
    "coulomb_nm": "coulomb_nm",
    "viscous_nm_s": "viscous_nm_s",
}
LOOP = {"delay_s": "delay_s", "speed_limit_rad_s": "speed_limit_rad_s"}
KEYS: Mapping[str, Mapping[str, str]] = {
    POSITION: {"kp_nm_rad": "kp", "kd_nm_s_rad": "kd", "torque_limit_nm": "limit", **LOOP},
    FIRMWARE: {
        "kp_duty_per_rad": "kp",
        "kd": "kd",
        "duty_limit": "limit",
        "supply_v": "supply_v",
        "torque_constant_nm_a": "torque_constant_nm_a",
        "resistance_ohm": "resistance_ohm",
        **LOOP,
    },
    TORQUE: {"torque_limit_nm": "limit"},
    CURRENT: {"torque_constant_nm_a": "torque_constant_nm_a", "torque_limit_nm": "limit"},
}
NEEDED = {
    POSITION: ("kp_nm_rad",),
    FIRMWARE: ("kp_duty_per_rad", "supply_v", "torque_constant_nm_a", "resistance_ohm"),
    TORQUE: (),
    CURRENT: ("torque_constant_nm_a",),
}
# What arrays of a log are called that hold such a number.
ALSO_CALLED = {"kp": "kp_nm_rad", "kd": "kd_nm_s_rad", "torque_limit": "torque_limit_nm"}
AFTER_ERROR = "error"  # kd_on: on the falling error, not on the speed


class JointNumbers(NamedTuple):
    """A driven joint, nominally or with causes in it; SI units, at the joint.

    ``kp``, ``kd`` and ``limit`` are in N m where the loop gives torque, in duty where it is a firmware's.
    ``strength`` is the share that its motor gives of a torque that the loop asks for.
    What is added to the model (armature, friction) is added to what its file has.
    """

    kp: float = 0.0
    kd: float = 0.0
    strength: float = 1.0
    limit: float = math.inf
    torque_constant_nm_a: float = 1.0
    supply_v: float = 0.0
    resistance_ohm: float = 1.0
    speed_limit_rad_s: float = UNLIMITED_RAD_S
    delay_s: float = 0.0
    lag_s: float = 0.0
    play_rad: float = 0.0
    backlash_rad: float = 0.0
    armature_kg_m2: float = 0.0
    coulomb_nm: float = 0.0
    viscous_nm_s: float = 0.0
    stribeck_nm: float = 0.0
    stribeck_rad_s: float = 0.5
    load_friction: float = 0.0
    compliance_rad_nm: float = 0.0
    encoder_offset_rad: float = 0.0
    encoder_scale: float = 1.0
    speed_scale: float = 1.0
    torque_scale: float = 1.0


class TorqueLaw(NamedTuple):
    """Torque = clip(stiffness (target - angle) - damping speed, limit) - back_emf speed."""

    stiffness: float
    damping: float
    limit: float
    back_emf: float

    def asked(self, target: FloatArray, angle: FloatArray, speed: FloatArray) -> FloatArray:
        """Return the torque that the loop asks for, before its motor's back-EMF; arrays of one shape."""
        pull = self.stiffness * (target - angle) - self.damping * speed
        return np.asarray(np.clip(pull, -self.limit, self.limit))


class DriveTable(NamedTuple):
    """What [drive] and the arrays of a log say."""

    kind: str
    joints: tuple[JointNumbers, ...]
    mounting: Mounting
    after_error: bool

    @property
    def forward(self) -> bool:
        """Whether commands are simulated; else torques are compared with what the motion needs."""
        return self.kind in {POSITION, FIRMWARE}


def torque_law(kind: str, p: JointNumbers) -> TorqueLaw:
    """Return the law by which a loop's torque follows its target, before its encoder's faults."""
    if kind == FIRMWARE:
        stall = p.torque_constant_nm_a * p.supply_v / p.resistance_ohm
        back_emf = p.torque_constant_nm_a**2 / p.resistance_ohm
    else:
        stall, back_emf = p.strength, 0.0
    kp, kd = stall * p.kp * p.encoder_scale, stall * p.kd * p.encoder_scale
    softer = 1.0 + kp * p.compliance_rad_nm  # the encoder sees the twist of what gives
    return TorqueLaw(kp / softer, kd / softer, stall * p.limit, back_emf)


def pursuing(p: JointNumbers, drive: DriveTable) -> JointNumbers:
    """Return a joint with only the numbers that say what its loop pursues."""
    kp, kd = (p.kp, p.kd) if drive.after_error else (1.0, 0.0)
    return JointNumbers(
        kp=kp, kd=kd, speed_limit_rad_s=p.speed_limit_rad_s, delay_s=p.delay_s, lag_s=p.lag_s,
        play_rad=p.play_rad, backlash_rad=p.backlash_rad, encoder_offset_rad=p.encoder_offset_rad,
        encoder_scale=p.encoder_scale,
    )  # fmt: skip


def read_drive(trial: Trial) -> DriveTable:
    """Read how the joints of a trial are driven.

    Raises:
        GapError: [drive] cannot be used, or says too little.
    """
    try:
        return _read(parse_table(trial.header.drive), trial)
    except ConfigError as error:
        raise GapError(f"[drive] beside the log cannot be used: {error}") from error


def _read(table: Table, trial: Trial) -> DriveTable:
    joints = trial.joints
    base = table.word("base", ("fixed", "free")) if table.has("base") else ""
    contact = table.has("contact") and table.word("contact", ("none", "full")) == "full"
    after = table.has("kd_on") and table.word("kd_on", ("speed", AFTER_ERROR)) == AFTER_ERROR
    constants = {ALSO_CALLED.get(name, name): values for name, values in trial.header.constants}
    own = table.maybe_table("joint")
    for name in own.names():
        if name not in joints:
            raise ConfigError(
                f"joint.{name}", f"is no joint of the log; there are {', '.join(joints)}"
            )
    kind = table.word("kind", KINDS) if table.has("kind") else ""
    kind = kind or _guessed(table, constants, trial)
    shared = _numbers(table, kind, len(joints))
    numbers, names = [], {}
    for at, joint in enumerate(joints):
        single = own.maybe_table(joint)
        if single.has("name"):
            names[joint] = single.text("name")
        given = {key: float(values[at if len(values) > 1 else 0]) for key, values in constants.items()
                 if key in KEYS[kind] and len(values) in {1, len(joints)}}  # fmt: skip
        given |= {key: values[at] for key, values in shared.items()}
        given |= {key: values[0] for key, values in _numbers(single, kind, 1).items()}
        single.done()
        numbers.append(_joint(given, kind, joint))
    own.done()
    table.done()
    return DriveTable(
        kind, tuple(numbers), Mounting(base, contact, names), after or kind == FIRMWARE
    )


def _guessed(table: Table, constants: Mapping[str, object], trial: Trial) -> str:
    """The kind that the numbers and the log's columns leave."""
    if table.has("kp_nm_rad") or "kp_nm_rad" in constants:
        return POSITION
    if table.has("kp_duty_per_rad") or table.has("p_gain"):
        return FIRMWARE
    if bool(np.isfinite(trial.torque_nm).any()):
        return TORQUE
    if table.has("torque_constant_nm_a") or table.has("joint"):
        return CURRENT
    raise ConfigError(
        "kind", "is missing: write [drive] kind = \"position\" with kp_nm_rad (and kd_nm_s_rad), "
        "\"firmware\" with p_gain and the motor, or \"torque\" or \"current\" beside the log"
    )  # fmt: skip


def _numbers(table: Table, kind: str, count: int) -> dict[str, list[float]]:
    """Numbers of a table by their keys, one a joint."""
    given: dict[str, list[float]] = {}
    for key in (*KEYS[kind], *COMMON):
        if table.has(key):
            raw = table.raw(key)
            values = raw if isinstance(raw, list) else [raw] * count
            if len(values) != count or not all(_sound(value) for value in values):
                raise ConfigError(
                    table.name(key), f"needs a number, or {count} of them, at least 0"
                )
            given[key] = [float(value) for value in values]
    if kind == FIRMWARE and table.has("p_gain"):
        divisor = table.number("p_gain_divisor", above=0.0, otherwise=P_GAIN_DIVISOR)
        per_register = TICKS_PER_TURN / (2 * math.pi) / (divisor * DUTY_FULL)
        given["kp_duty_per_rad"] = [table.number("p_gain", minimum=0.0) * per_register] * count
    if kind in {FIRMWARE, CURRENT} and table.has("gear"):
        gear = table.number("gear", above=0.0)
        constant = given.get("torque_constant_nm_a", [math.nan] * count)
        given["torque_constant_nm_a"] = [gear * one for one in constant]
    return given


def _sound(value: object) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(float(str(value))) and float(str(value)) >= 0.0


def _joint(given: Mapping[str, float], kind: str, joint: str) -> JointNumbers:
    for key in NEEDED[kind]:
        value = given.get(key, math.nan)
        if not value > 0.0:
            raise ConfigError(
                key, f"is missing for {joint}: a drive of kind {kind!r} needs it, above 0"
            )
    fields = {**KEYS[kind], **COMMON}
    numbers = {fields[key]: value for key, value in given.items()}
    if kind == FIRMWARE:
        numbers.setdefault("limit", 1.0)
    return JointNumbers(**numbers)
