"""Versions of everything whose change could change a log, as texts for its metadata."""

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType

PACKAGES = ("bigant", "numpy", "scipy", "numba", "mujoco-core", "dynamixel-sdk", "mcap")
PREFIX = "version."


def software_versions() -> Mapping[str, str]:
    """Return metadata keys and versions: the same on every run of one installation."""
    found = {f"{PREFIX}python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[f"{PREFIX}{package}"] = version(package)
        except PackageNotFoundError:
            found[f"{PREFIX}{package}"] = "not installed"
    return MappingProxyType(found)
