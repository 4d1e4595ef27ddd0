"""What the counts of a log's force records mean, as a text among the log's metadata."""

import json
from collections.abc import Mapping, Sequence

from drivers.ati.calibration import Calibration
from model.errors import RecordError

UNITS_KEY = "force_units"


def units_text(names: Sequence[str], calibrations: Sequence[Calibration | None]) -> str:
    """Return transducer, serial number and counts per unit of each leg's sensor."""
    found = {
        name: {
            "transducer": c.transducer,
            "serial": c.serial,
            "date": c.date,
            "part": c.part,
            "counts_per_n": c.counts_per_n,
            "counts_per_nm": c.counts_per_nm,
        }
        for name, c in zip(names, calibrations, strict=True)
        if c is not None
    }
    return json.dumps(found)


def units_of(metadata: Mapping[str, str], names: Sequence[str]) -> tuple[Calibration | None, ...]:
    """Read them back.

    Args:
        metadata: The log's metadata.
        names: Leg names.

    Raises:
        RecordError: The log does not say.
    """
    text = metadata.get(UNITS_KEY, "")
    if not text:
        raise RecordError(
            "the log does not say what its force counts mean (it is older than that): record anew"
        )
    try:
        found = json.loads(text)
        return tuple(_calibration(found[name]) if name in found else None for name in names)
    except (ValueError, KeyError, TypeError) as error:
        raise RecordError(f"the log's {UNITS_KEY} cannot be read: {error}") from error


def _calibration(entry: Mapping[str, object]) -> Calibration:
    return Calibration(
        transducer=int(str(entry["transducer"])),
        serial=str(entry["serial"]),
        date=str(entry["date"]),
        part=str(entry["part"]),
        counts_per_n=float(str(entry["counts_per_n"])),
        counts_per_nm=float(str(entry["counts_per_nm"])),
        mult_on=True,
        max_rating=(float("nan"),) * 6,
    )
