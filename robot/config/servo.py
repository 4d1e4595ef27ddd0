"""The table ``[servo]`` of a robot file: which servos, what a gait may ask of them, what stops it."""

import difflib
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106
from drivers.dynamixel.model_words import PAGE
from drivers.dynamixel.servo_model import ServoModel
from model.errors import ConfigError
from model.parameters.toml_table import Table
from model.values.parameters import ServoParameters


@dataclass(frozen=True, slots=True)
class SafetyLimits:
    """Limits that stop the robot.

    Attributes:
        max_speed_rad_s: Fastest command the gate lets through.
        max_temperature_c: Hottest servo.
        min_voltage_v: Lowest supply.
        max_current_a: Largest motor current; infinite where no servo measures one.
        max_following_error_rad: Largest difference between a shaft and its command.
    """

    max_speed_rad_s: float
    max_temperature_c: float
    min_voltage_v: float
    max_current_a: float
    max_following_error_rad: float


@dataclass(frozen=True, slots=True)
class ServoTable:
    """What the table says.

    Attributes:
        models: Model of each leg's servo, N of them.
        parameters: What the model and the gaits assume of them.
        limits: What stops the robot.
    """

    models: tuple[ServoModel, ...]
    parameters: ServoParameters
    limits: SafetyLimits


def read_servo(table: Table, legs: int) -> ServoTable:
    """Read the table.

    A limit beyond what a servo can do or measure is none, so each has to lie within what every model of the
    robot can be set to.

    Args:
        table: The table.
        legs: Number of legs N.

    Raises:
        ConfigError: A key in it cannot be used.
    """
    models = _models(table, legs)
    speed = _at_most(table, "max_speed", "rad/s", _least(models, lambda m: m.highest_speed_rad_s))
    parameters = ServoParameters(
        supply_voltage=_voltage(table, models),
        rated_torque_limit=table.number("rated_torque_limit", above=0),
        max_speed=speed,
        max_acceleration=table.number("max_acceleration", above=0),
        models=tuple(model.name for model in models),
    )
    limits = SafetyLimits(
        max_speed_rad_s=speed,
        max_temperature_c=table.number("max_temperature", above=0, maximum=100),
        min_voltage_v=table.number("min_voltage", above=0, below=parameters.supply_voltage),
        max_current_a=_current(table, models),
        max_following_error_rad=table.number("max_following_error", above=0, maximum=math.pi),
    )
    return ServoTable(models, parameters, limits)


def _models(table: Table, legs: int) -> tuple[ServoModel, ...]:
    """Return the model of each leg's servo: one name for all or one a leg; the MX-106 without the key."""
    if not table.has("model"):
        return (MX_106,) * legs
    names = table.raw("model")
    if isinstance(names, str):
        return (_model(table.name("model"), names),) * legs
    if not isinstance(names, list) or len(names) != legs:
        words = f"must be one model, or a list with one a leg ({legs}), not {names!r}"
        raise ConfigError(table.name("model"), words)
    return tuple(_model(f"{table.name('model')}[{i}]", name) for i, name in enumerate(names))


def _model(key: str, name: object) -> ServoModel:
    if isinstance(name, str) and name in MODEL_BY_NAME:
        return MODEL_BY_NAME[name]
    near = difflib.get_close_matches(str(name).upper(), MODEL_BY_NAME, n=1)
    hint = f" (is {near[0]!r} meant?)" if near else ""
    known = ", ".join(MODEL_BY_NAME)
    words = f"{name!r} is no servo known here{hint}; known are {known}; how to add one: {PAGE}"
    raise ConfigError(key, words)


def _least(models: Iterable[ServoModel], most: Callable[[ServoModel], float]) -> tuple[float, str]:
    """Return the smallest of what the models can do, and whose it is."""
    least = min(models, key=most)
    return most(least), least.name


def _at_most(table: Table, key: str, unit: str, most: tuple[float, str]) -> float:
    """Return a number above 0 that a servo can be set to.

    Raises:
        ConfigError: It cannot; the error names the model.
    """
    value, (highest, name) = table.number(key, above=0), most
    if value > highest:
        words = f"must be at most {highest:.4g} {unit}, as far as an {name} goes, not {value:g}"
        raise ConfigError(table.name(key), words)
    return value


def _voltage(table: Table, models: tuple[ServoModel, ...]) -> float:
    value = table.number("supply_voltage", above=0)
    for model in models:
        low, high = model.lowest_voltage_v, model.highest_voltage_v
        if not low - 1e-9 <= value <= high + 1e-9:
            words = f"must be {low:g} to {high:g} V for an {model.name}, not {value:g}"
            raise ConfigError(table.name("supply_voltage"), words)
    return value


def _current(table: Table, models: tuple[ServoModel, ...]) -> float:
    """Return the limit on current; it may be left out where no servo measures one."""
    measuring = [model for model in models if model.measures_current]
    if not measuring and not table.has("max_current"):
        return math.inf
    if not measuring:
        return table.number("max_current", above=0)
    return _at_most(table, "max_current", "A", _least(measuring, lambda m: m.highest_current_a))
