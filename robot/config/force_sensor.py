"""The tables ``[force_sensor]`` and ``legs.transducer``; a robot without either has no force sensors."""

import numpy as np

from drivers.ati.settings import ForceSensorSettings, no_sensors
from model.errors import ConfigError
from model.parameters.toml_table import Table
from model.values.arrays import IntArray, readonly

FORCE_SENSOR = "force_sensor"
TRANSDUCER = "transducer"
MOST_SAMPLES = 4000  # a second


def read_transducers(legs: Table, count: int) -> IntArray:
    """Return the transducer of each leg, (N,), 0 for none; no leg has one without the key.

    Raises:
        ConfigError: The key is of another length, or a number is none of a unit's.
    """
    if not legs.has(TRANSDUCER):
        return readonly(np.zeros(count, dtype=np.int64))
    return legs.integers(TRANSDUCER, count, minimum=0, maximum=6)


def read_force_sensor(
    top: Table, names: tuple[str, ...], transducers: IntArray
) -> tuple[ForceSensorSettings, str]:
    """Read [force_sensor] of a whole robot file.

    Returns:
        The settings, and the calibration file that they name, empty for none.

    Raises:
        ConfigError: The table is wrong, or there are transducers without it.
    """
    if top.has(FORCE_SENSOR):
        table = top.table(FORCE_SENSOR)
        return _settings(table, names, transducers), table.maybe_text("calibration")
    if transducers.any():
        raise ConfigError(
            FORCE_SENSOR,
            "is missing, and legs.transducer names transducers; add it, or take legs.transducer out",
        )
    return no_sensors(names), ""


def _settings(table: Table, names: tuple[str, ...], transducers: IntArray) -> ForceSensorSettings:
    rate = table.integer("rate", minimum=5, maximum=MOST_SAMPLES)
    oversampling = table.integer("oversampling", minimum=1, maximum=32)
    if rate * oversampling > MOST_SAMPLES:
        raise ConfigError(
            table.name("oversampling"),
            f"rate x oversampling is {rate * oversampling}, the unit samples at most "
            f"{MOST_SAMPLES} a second",
        )
    count = len(names)
    return ForceSensorSettings(
        names=names,
        transducers=transducers,
        address=table.text("address"),
        udp_port=table.integer("udp_port", minimum=1, maximum=65535),
        console_port=table.integer("console_port", minimum=1, maximum=65535),
        local_port=table.integer("local_port", minimum=0, maximum=65535),
        rate_hz=rate,
        oversampling=oversampling,
        silent_limit_s=table.number("silent_limit", above=0, maximum=60),
        offset_m=table.numbers("offset", (count, 3)),
        yaw_rad=table.numbers("yaw", (count,)),
        up=_mounted_up(table, count),
        bias_n=table.numbers("bias", (count, 3)),
    )


def _mounted_up(table: Table, count: int) -> IntArray:
    """Return which way up the sensors are, (N,); all of them upright without the key."""
    if not table.has("up"):
        return readonly(np.ones(count, dtype=np.int64))
    up = table.integers("up", count, minimum=-1, maximum=1)
    if np.any(up == 0):
        raise ConfigError(table.name("up"), "must be 1 or -1, not 0")
    return up
