"""The console's CAL table: what counts mean. Read by its labels, never by position.

Two traps it has to catch: units differ between sensors of one unit (a sensor may report counts per
N-mm where another reports per N-m, a factor of 1000), and a transducer may be set to send raw gage
counts (``Mult: OFF``), for which no force exists without the matrix.
"""

import math
import re
from dataclasses import dataclass

from model.errors import ForceStreamError

FORCE_UNITS_N = {
    "N": 1.0, "kN": 1e3, "lbf": 4.4482216152605, "klbf": 4448.2216152605, "g": 9.80665e-3,
    "kg": 9.80665,
}  # fmt: skip
TORQUE_UNITS_NM = {
    "N-m": 1.0, "Nm": 1.0, "N-mm": 1e-3, "kN-m": 1e3, "lbf-in": 0.1129848290276167,
    "lbf-ft": 1.3558179483314004, "kg-cm": 0.0980665,
}  # fmt: skip
AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
_PROPERTY = re.compile(r"\b(Serial|Date|Part|Force|Torque|Mult):\s*(.*?)\s*$", re.MULTILINE)
_SCALE = re.compile(r"^([-+0-9.eE]+)\s+counts/(.*)$")


@dataclass(frozen=True, slots=True)
class Calibration:
    """Active calibration of one transducer.

    Attributes:
        transducer: Its number, 1 to 6.
        serial: Serial number.
        date: Calibration date as printed.
        part: Part name.
        counts_per_n: Counts per newton.
        counts_per_nm: Counts per newton metre.
        mult_on: Whether it sends forces (True) or raw gage counts.
        max_rating: Largest Fx Fy Fz [N] and Tx Ty Tz [N m]; NaN where not printed.
    """

    transducer: int
    serial: str
    date: str
    part: str
    counts_per_n: float
    counts_per_nm: float
    mult_on: bool
    max_rating: tuple[float, ...]

    @property
    def calibrated(self) -> bool:
        """Whether it has ever been calibrated; a date in January 1970 says that it has not."""
        return not re.match(r"1970/0?1/", self.date)


def parse_cal(text: str, transducer: int) -> Calibration:
    """Read the answer to CAL.

    Args:
        text: Everything the console printed.
        transducer: The transducer asked about.

    Raises:
        ForceStreamError: The answer lacks something, or a unit is unknown.
    """
    properties = dict(_PROPERTY.findall(text))
    missing = [name for name in ("Serial", "Force", "Torque", "Mult") if name not in properties]
    if missing:
        raise ForceStreamError(
            f"the calibration of transducer {transducer} lacks {', '.join(missing)}: check on the "
            f"unit's console with TRANS {transducer} and CAL"
        )
    force_counts, force_unit = _scale(properties["Force"], FORCE_UNITS_N, "Force", transducer)
    torque_counts, torque_unit = _scale(properties["Torque"], TORQUE_UNITS_NM, "Torque", transducer)
    ratings = _ratings(text)
    to_si = [force_unit] * 3 + [torque_unit] * 3
    return Calibration(
        transducer=transducer,
        serial=properties["Serial"],
        date=properties.get("Date", ""),
        part=properties.get("Part", ""),
        counts_per_n=force_counts / force_unit,
        counts_per_nm=torque_counts / torque_unit,
        mult_on=properties["Mult"].upper() == "ON",
        max_rating=tuple(r * s for r, s in zip(ratings, to_si, strict=True)),
    )


def _scale(text: str, units: dict[str, float], label: str, transducer: int) -> tuple[float, float]:
    match = _SCALE.match(text)
    counts = _number(match.group(1)) if match else 0.0
    unit = match.group(2).strip() if match else text
    if not 0 < counts < math.inf or unit not in units:
        raise ForceStreamError(
            f"transducer {transducer} reports {label} as {text!r}, which is no scale we know "
            f"(units {', '.join(units)}); choose another calibration with CALIB on its console"
        )
    return counts, units[unit]


def _ratings(text: str) -> list[float]:
    lines = text.splitlines()
    for number, line in enumerate(lines[:-1]):
        if "MaxRatings" in line:
            values = lines[number + 1].split()[-len(AXES) :]
            if len(values) == len(AXES):
                return [_number(value) for value in values]
    return [math.nan] * len(AXES)


def _number(text: str) -> float:
    """Return a number as printed; NaN for a garbled one."""
    try:
        return float(text)
    except ValueError:
        return math.nan
