"""What is installed: the versions at work, and how an optional package is added."""

import platform

from record.log.header import PACKAGES, version_of


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra of ours, to be typed in the clone."""
    return f"pip install -e '.[{extra}]'"


def version_lines() -> list[str]:
    """Return what ``bigant --version`` prints."""
    from model.compiled import COMPILED

    packages = ", ".join(f"{name} {version_of(name)}" for name in PACKAGES[1:])
    model = "compiled" if COMPILED else "NOT compiled: numba is missing, the model is slow"
    return [
        f"bigant {version_of('bigant')}, Python {platform.python_version()}, {platform.platform()}",
        packages,
        f"model: {model}",
    ]
