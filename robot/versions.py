"""Which versions of what are at work: for ``bigant --version`` and for reports."""

import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "filterpy",
    "dynamixel-sdk",
    "pyserial",
    "mujoco-core",
    "mcap",
)


def version_of(package: str) -> str:
    """Version of an installed package, ``missing`` if there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "missing"


def version_lines() -> list[str]:
    """Return what ``bigant --version`` prints."""
    from model.compiled import COMPILED

    packages = ", ".join(f"{name} {version_of(name)}" for name in PACKAGES)
    model = "compiled" if COMPILED else "NOT compiled: numba is missing, the model is slow"
    return [
        f"bigant {version_of('bigant')}, Python {platform.python_version()}, {platform.platform()}",
        packages,
        f"model: {model}",
    ]
