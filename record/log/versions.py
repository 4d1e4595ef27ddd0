"""Versions of everything whose change could change a log, as texts for its metadata."""

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType

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


def version_of(package: str) -> str:
    """Return the version of an installed package, ``not installed`` if there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return NOT_INSTALLED


def software() -> str:
    """Return name and version of this program."""
    return f"bigant {version_of('bigant')}"


def software_versions() -> Mapping[str, str]:
    """Return metadata keys and versions: the same on every run of one installation."""
    versions = {package: version_of(package) for package in PACKAGES}
    versions["python"] = platform.python_version()
    return MappingProxyType({f"{PREFIX}{name}": found for name, found in versions.items()})
