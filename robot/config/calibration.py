"""The calibration file of the force sensors: a TOML made by ``bigant force``, read strictly.

One table a sensor; a leg without one is not calibrated, and its forces are not valid.
"""

from pathlib import Path

import numpy as np

from model.errors import ConfigError
from model.parameters.tables import parse_table
from model.values.arrays import readonly
from model.values.force_calibration import AXES, METHODS, ForceCalibration
from record.toml_file import reading, toml_text
from record.whole_file import write_text

FORMAT = 1
LARGEST_HARMONICS = 8
CALIBRATION_KEY = "force_calibration"  # of a log's metadata


def format_calibration(calibration: ForceCalibration) -> str:
    """Return the text of a calibration file."""
    known = [bool(np.isfinite(one).all()) for one in calibration.unloaded]
    head = (
        "Force sensors to foot wrenches, made by bigant force. Sensor axes; N and N m.",
        "foot wrench = (I + correction) (reading - unloaded(shaft angle))",
        f"One row an axis, {' '.join(AXES)}; unloaded: constant, cos q, sin q, cos 2q, sin 2q, ...;",
        "standard_error: of unloaded at shaft angle 0.",
        *(
            f"{name}: not calibrated"
            for name, there in zip(calibration.legs, known, strict=True)
            if not there
        ),
    )
    sensors = {
        name: _sensor(calibration, leg) for leg, name in enumerate(calibration.legs) if known[leg]
    }
    table = {
        "format": FORMAT,
        "method": calibration.method,
        "date": calibration.date,
        "logs": calibration.logs,
        "harmonics": calibration.harmonics,
        "legs": calibration.legs,
        "sensor": sensors or None,
    }
    return toml_text(table, head)


def _sensor(calibration: ForceCalibration, leg: int) -> dict[str, object]:
    error = calibration.standard_error[leg]
    return {
        "serial": calibration.serials[leg] or None,
        "unloaded": calibration.unloaded[leg].tolist(),
        "correction": calibration.correction[leg].tolist(),
        "standard_error": error.tolist() if np.isfinite(error).all() else None,
    }


def calibration_text(calibration: ForceCalibration | None) -> str:
    """Return what a log keeps of the calibration in use: its file's text, or nothing."""
    return "" if calibration is None else format_calibration(calibration)


def write_calibration(path: Path, calibration: ForceCalibration) -> None:
    """Write a calibration file.

    Raises:
        RecordError: It cannot be written.
    """
    write_text(path, format_calibration(calibration))


def read_calibration(path: Path, legs: tuple[str, ...]) -> ForceCalibration:
    """Read a calibration file for a robot's legs.

    Raises:
        ConfigError: It cannot be read, or a key in it cannot be used, or it is of other legs.
    """
    with reading(path, "the calibration file") as text:
        return parse_calibration(text, legs)


def parse_calibration(text: str, legs: tuple[str, ...]) -> ForceCalibration:
    """Read the text of a calibration file; legs without a table come back as NaN.

    Raises:
        ConfigError: It is no TOML, a key in it cannot be used, or it is of other legs.
    """
    top = parse_table(text, "calibration file")
    top.integer("format", minimum=FORMAT, maximum=FORMAT)
    method = top.word("method", METHODS)
    named = top.texts("legs")
    if named != legs:
        raise ConfigError(
            "legs", f"{', '.join(named)} are not this robot's legs, {', '.join(legs)}"
        )
    width = 1 + 2 * top.integer("harmonics", minimum=0, maximum=LARGEST_HARMONICS)
    count = len(legs)
    unloaded = np.full((count, 6, width), np.nan)
    correction = np.zeros((count, 6, 6))
    spread = np.full((count, 6), np.nan)
    serials = [""] * count
    if top.has("sensor"):
        sensors = top.table("sensor")
        for leg, name in enumerate(legs):
            if sensors.has(name):
                table = sensors.table(name)
                serials[leg] = table.maybe_text("serial")
                unloaded[leg] = table.numbers("unloaded", (6, width))
                correction[leg] = table.numbers("correction", (6, 6))
                if table.has("standard_error"):
                    spread[leg] = table.numbers("standard_error", (6,))
    calibration = ForceCalibration(
        legs=legs,
        serials=tuple(serials),
        unloaded=readonly(unloaded),
        correction=readonly(correction),
        standard_error=readonly(spread),
        method=method,
        date=top.text("date"),
        logs=top.texts("logs"),
    )
    top.done()
    return calibration
