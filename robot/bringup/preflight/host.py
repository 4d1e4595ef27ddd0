"""The computer's part of the pre-flight list: disk for the log, versions of what runs."""

import platform
import shutil
from collections.abc import Iterator
from pathlib import Path

from record.log.versions import NOT_INSTALLED, version_of
from robot.bringup.preflight.finding import Finding, failed, passed, warned

GB = 1e9
# A log grows by well under 1 GB an hour at 100 Hz.
LEAST_FREE_GB = 0.5
ENOUGH_FREE_GB = 5.0
PYTHONS = ((3, 11), (3, 13))
NEEDED = ("numpy", "mcap", "dynamixel-sdk", "pyserial")


def host_findings(log_folder: Path) -> Iterator[Finding]:
    """Look at the computer."""
    yield disk_finding(shutil.disk_usage(_existing(log_folder)).free / GB, str(log_folder))
    yield python_finding(platform.python_version_tuple())
    yield packages_finding({name: version_of(name) for name in (*NEEDED, "numba")})


def _existing(folder: Path) -> Path:
    folder = folder.absolute()
    while not folder.exists():
        folder = folder.parent
    return folder


def disk_finding(free_gb: float, where: str) -> Finding:
    """Judge the free space for logs."""
    found = f"{free_gb:.1f} GB free for logs in {where}"
    if free_gb < LEAST_FREE_GB:
        return failed("disk", found, "delete something, or choose another folder with --log")
    if free_gb < ENOUGH_FREE_GB:
        return warned("disk", found, "enough for a few walks; make room")
    return passed("disk", found)


def python_finding(version: tuple[str, ...]) -> Finding:
    """Judge the version of Python."""
    lowest, highest = PYTHONS
    found = ".".join(version)
    if lowest <= (int(version[0]), int(version[1])) <= highest:
        return passed("Python", found)
    return warned(
        "Python", found, f"tested from {lowest[0]}.{lowest[1]} to {highest[0]}.{highest[1]} only"
    )


def packages_finding(versions: dict[str, str]) -> Finding:
    """Judge which packages are there."""
    found = ", ".join(f"{name} {version}" for name, version in versions.items())
    gone = [name for name in NEEDED if versions[name] == NOT_INSTALLED]
    if gone:
        return failed("packages", found, f"install {', '.join(gone)}")
    if versions["numba"] == NOT_INSTALLED:
        return warned("packages", found, "install numba: without it the model is slow")
    return passed("packages", found)
