"""The robot file: one TOML a robot, read once into frozen dataclasses.

Unknown or missing keys, wrong lengths, non-finite and impossible values are a ``ConfigError`` that
names the key and the reason. Nothing else in the program reads configuration.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.ati.settings import ForceSensorSettings, no_sensors
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.settings import ServoBusSettings
from gaits.catalog import make_gaits
from model.effects.causes import Cause
from model.effects.written import causes_for
from model.errors import ConfigError
from model.parameters.tables import (
    parse_table,
    read_body,
    read_contact,
    read_leg,
    read_legs,
)
from model.parameters.toml_table import Table
from model.values.parameters import (
    ChainParameters,
    LegGeometry,
    LegParameters,
    RobotParameters,
)
from record.chain_file import complete
from record.toml_file import reading
from robot.config.calibration import read_calibration
from robot.config.estimator import EstimatorConfig, read_estimator
from robot.config.force_sensor import read_force_sensor, read_transducers
from robot.config.gaits import read_gaits
from robot.config.imu import NO_IMU, ImuConfig, read_imu
from robot.config.safety import BodyLimits, RecoverySettings, read_body_limits, read_recovery
from robot.config.servo import SafetyLimits, read_servo
from robot.config.stance import check_stance
from robot.config.undriven import (
    DRIVING_TABLES,
    UNKNOWN,
    no_servo,
    no_servo_bus,
    not_driven,
)
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.shipped import ROBOT_FILE_PAGE

LONGEST_LATE_S = 0.1
WATCHDOG_STEP_S = 0.02


@dataclass(frozen=True, slots=True)
class LoopSettings:
    """The loop: rate, when a tick is late, how many late ticks in a row stop the robot."""

    rate_hz: int
    late_limit_s: float
    late_ticks: int


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """One robot file, read.

    Attributes:
        name: Name of the robot.
        text: The file as it was read; it goes into every log.
        parameters: What the model and the gaits assume.
        servo_bus: Servo bus settings.
        force_sensor: Force-torque unit settings; without transducers for a robot that has none.
        calibration_file: Calibration file that the robot file names, empty for none.
        limits: Safety limits of the servos.
        loop: Loop settings.
        body_limits: Safety limits of the body.
        recovery: Whether a servo that lost its torque may be brought back.
        effects: What the file adds to the nominal model.
        estimator: Odometry inside the loop.
        imu: The IMU, if there is one.
    """

    name: str
    text: str
    parameters: RobotParameters
    servo_bus: ServoBusSettings
    force_sensor: ForceSensorSettings
    calibration_file: str
    limits: SafetyLimits
    loop: LoopSettings
    body_limits: BodyLimits
    recovery: RecoverySettings
    estimator: EstimatorConfig
    effects: tuple[Cause, ...] = ()
    imu: ImuConfig = NO_IMU

    @property
    def driven(self) -> bool:
        """Whether the robot can be driven: its file names the servos of its legs."""
        return bool(self.servo_bus.names)


def load_robot(
    path: str | Path = DEFAULT_ROBOT_FILE,
    calibration: str | Path | None = None,
    *,
    driven: bool = True,
) -> RobotConfig:
    """Read a robot file, and the calibration of its force sensors where it has one.

    Args:
        path: The robot file; the nominal BigANT where none is named.
        calibration: Calibration file to take in place of the one that the robot file names.
        driven: Whether the robot must be one that can be driven: legs of several joints cannot be, nor a
            robot whose file has no table of what drives it.

    Raises:
        ConfigError: A file cannot be read, a key in it cannot be used, or the robot cannot be driven.
    """
    file = Path(path)
    with reading(file, "the robot file", ROBOT_FILE_PAGE) as text:
        config = parse_robot(complete(text, file.parent))
    if driven and not config.driven:
        raise not_driven(config.parameters.leg)
    if calibration is None and config.calibration_file:
        calibration = file.parent / config.calibration_file
    if calibration is None:
        return config
    if not config.force_sensor.any:
        raise ConfigError(str(calibration), "calibrates force sensors, and the robot file has none")
    read = read_calibration(Path(calibration), config.parameters.legs.names)
    return replace(config, force_sensor=replace(config.force_sensor, calibration=read))


def parse_robot(text: str) -> RobotConfig:
    """Read the text of a robot file; a calibration file that it names is not opened.

    Raises:
        ConfigError: It is no TOML, or a key in it cannot be used.
    """
    top = parse_table(text)
    name, leg = top.text("name"), read_leg(top)
    if isinstance(leg, ChainParameters) or not DRIVING_TABLES.intersection(top.names()):
        return _undriven(text, top, leg)
    legs, bus_columns = _legs(top.table("legs"), leg)
    servo = read_servo(top.table("servo"), legs.count)
    parameters = RobotParameters(
        body=read_body(top.table("body")),
        legs=legs,
        leg=leg,
        contact=read_contact(top.table("contact"), legs.count),
        servo=servo.parameters,
        gaits=read_gaits(top.maybe_table("gait"), legs),
    )
    make_gaits(parameters)  # refuses what cannot be a gait
    check_stance(parameters)
    loop = _loop(top.table("loop"))
    safety_table = top.maybe_table("safety")
    force_sensor, calibration_file = read_force_sensor(top, legs.names, bus_columns.transducers)
    config = RobotConfig(
        name=name,
        text=text,
        parameters=parameters,
        servo_bus=_servo_bus(top.table("servo_bus"), legs, bus_columns, servo.models, loop),
        force_sensor=force_sensor,
        calibration_file=calibration_file,
        limits=servo.limits,
        loop=loop,
        body_limits=read_body_limits(safety_table),
        recovery=read_recovery(safety_table),
        effects=causes_for(top, parameters.body.mass, legs, parameters.leg),
        estimator=read_estimator(top.maybe_table("estimator"), legs.count),
        imu=read_imu(top.maybe_table("imu")),
    )
    top.done()
    return config


def _undriven(text: str, top: Table, leg: LegGeometry) -> RobotConfig:
    """A robot that is measured and not driven: what the model, the estimator and pictures need."""
    legs = read_legs(top.table("legs"), leg)
    body = read_body(top.table("body"))
    config = RobotConfig(
        name=top.text("name"),
        text=text,
        parameters=RobotParameters(
            body=body,
            legs=legs,
            leg=leg,
            contact=read_contact(top.table("contact"), legs.count),
            servo=no_servo(),
            gaits=(),
        ),
        servo_bus=no_servo_bus(),
        force_sensor=no_sensors(legs.names),
        calibration_file="",
        limits=SafetyLimits(UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN),
        loop=LoopSettings(0, UNKNOWN, 0),
        body_limits=BodyLimits(),
        recovery=RecoverySettings(),
        effects=causes_for(top, body.mass, legs, leg),
        estimator=read_estimator(top.maybe_table("estimator"), legs.count),
        imu=read_imu(top.maybe_table("imu")),
    )
    top.done()
    return config


@dataclass(frozen=True, slots=True, eq=False)
class _WiringColumns:
    ids: np.ndarray
    signs: np.ndarray
    zeros: np.ndarray
    transducers: np.ndarray


def _legs(table: Table, leg: LegGeometry) -> tuple[LegParameters, _WiringColumns]:
    legs = read_legs(table, leg)
    names, count = legs.names, legs.count
    columns = _WiringColumns(
        ids=table.integers("dynamixel_id", count, minimum=0, maximum=252),
        signs=table.integers("servo_sign", count, minimum=-1, maximum=1),
        zeros=table.integers("servo_zero", count, minimum=0, maximum=4095),
        transducers=read_transducers(table, count),
    )
    ids = dict(zip(names, columns.ids.tolist(), strict=True))
    _no_repeat(table.name("dynamixel_id"), ids, "two servos cannot share id")
    numbers = zip(names, columns.transducers.tolist(), strict=True)
    used = {name: number for name, number in numbers if number > 0}
    _no_repeat(table.name("transducer"), used, "two legs cannot share transducer")
    if np.any(columns.signs == 0):
        raise ConfigError(table.name("servo_sign"), "must be 1 or -1, not 0")
    return legs, columns


def _no_repeat(key: str, numbers: Mapping[str, int], words: str) -> None:
    """Refuse a number that several legs have."""
    for number in numbers.values():
        legs = [leg for leg, other in numbers.items() if other == number]
        if len(legs) > 1:
            raise ConfigError(key, f"{words} {number} (legs {', '.join(legs)})")


def _loop(table: Table) -> LoopSettings:
    return LoopSettings(
        rate_hz=table.integer("rate", minimum=1, maximum=200),
        late_limit_s=table.number("late_limit", above=0, maximum=LONGEST_LATE_S),
        late_ticks=table.integer("late_ticks", minimum=1, maximum=1000),
    )


def _servo_bus(
    table: Table,
    legs: LegParameters,
    columns: _WiringColumns,
    models: tuple[ServoModel, ...],
    loop: LoopSettings,
) -> ServoBusSettings:
    watchdog = table.number("watchdog", minimum=WATCHDOG_STEP_S, maximum=127 * WATCHDOG_STEP_S)
    steps = watchdog / WATCHDOG_STEP_S
    if abs(steps - round(steps)) > 1e-6:
        raise ConfigError(table.name("watchdog"), f"must be a multiple of 0.02 s, not {watchdog:g}")
    if watchdog < 3 / loop.rate_hz:
        raise ConfigError(
            table.name("watchdog"),
            f"{watchdog:g} s is less than three periods of the loop at {loop.rate_hz} Hz; "
            "it would trip in ordinary running",
        )
    return ServoBusSettings(
        names=legs.names,
        ids=columns.ids,
        signs=columns.signs,
        zeros=columns.zeros,
        models=models,
        baud_rate=_baud_rate(table, models),
        watchdog_s=watchdog,
        silent_limit=table.integer("silent_limit", minimum=1, maximum=200),
    )


def _baud_rate(table: Table, models: tuple[ServoModel, ...]) -> int:
    baud_rate = table.integer("baud_rate", minimum=9600, maximum=4_500_000)
    for model in models:
        if baud_rate > model.baud_rates[-1]:
            words = f"is more than an {model.name} can be set to ({model.baud_rates[-1]})"
            raise ConfigError(table.name("baud_rate"), words)
    return baud_rate
