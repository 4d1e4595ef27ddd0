"""A run as a whole in a log's metadata, with the versions of everything whose change could change a log."""

import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib.metadata import PackageNotFoundError, version

PACKAGES = (
    "bigant",
    "numpy",
    "scipy",
    "numba",
    "filterpy",
    "dynamixel-sdk",
    "pyserial",
    "mujoco-core",
    "mcap",
)
PREFIX = "version."
NOT_INSTALLED = "not installed"
IMPORTED = "imported"  # in place of the hardware: no controller made this log


@cache  # a package's whole description is read for it: 6 ms, and ten packages a log
def version_of(package: str) -> str:
    """Return the version of an installed package, ``not installed`` if there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return NOT_INSTALLED


def software_versions() -> Mapping[str, str]:
    """Return metadata keys and versions: the same on every run of one installation."""
    versions = {package: version_of(package) for package in PACKAGES}
    versions["python"] = platform.python_version()
    return {
        "software": f"bigant {versions['bigant']}",
        **{f"{PREFIX}{name}": version for name, version in versions.items()},
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class RunHeader:
    """A run in a few words. In the log's metadata each field stands under its own name, as text.

    Attributes:
        robot: Name of the robot.
        hardware: ``virtual``, the serial port of the servo bus, or ``IMPORTED``.
        time: ``virtual`` or ``real``; empty where no loop of ours ran.
        gait: Gait that it began with.
        frequency_hz: Its frequency; None or NaN where it is not known.
        steer: -1 (right) to 1 (left), None where it is not known.
        seed: Seed of virtual noise, None without any.
        scenario: File of the faults of virtual hardware, empty for none.
        warnings: What the model warned of in the robot file, one a line.
        trial: Header of the trial that the log was made from, empty for none.
    """

    robot: str
    hardware: str
    time: str = ""
    gait: str = ""
    frequency_hz: float | None = None
    steer: float | None = None
    seed: int | None = None
    scenario: str = ""
    warnings: str = ""
    trial: str = ""

    def metadata(self) -> Mapping[str, str]:
        """Return the texts, without those that say nothing; with the versions of all software."""
        texts = {field.name: _text(getattr(self, field.name)) for field in fields(self)}
        known = {key: text for key, text in texts.items() if text}
        return {**known, **software_versions()}


def _text(value: str | float | None) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:g}"
    return "" if value is None else str(value)
