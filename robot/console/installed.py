"""What is installed: the versions at work, and how an optional package is added."""

import platform
from importlib.metadata import requires

from record.log.header import PACKAGES, version_of
from robot.console.shipped import INSTALLED


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra of ours: in the clone, or beside an installed wheel."""
    if not INSTALLED:
        return f"pip install -e '.[{extra}]'"
    own = (text.partition(";") for text in requires("bigant") or ())
    packages = [
        one.strip() for one, _, when in own if f"extra == '{extra}'" in when.replace('"', "'")
    ]
    return " ".join(["pip install", *(f"'{one}'" for one in packages)])


def version_lines() -> list[str]:
    """Return what ``bigant --version`` prints."""
    from model.compiled import compiles

    packages = ", ".join(f"{name} {version_of(name)}" for name in PACKAGES[1:])
    model = "compiled" if compiles() else "NOT compiled: numba is missing, the model is slow"
    return [
        f"bigant {version_of('bigant')}, Python {platform.python_version()}, {platform.platform()}",
        packages,
        f"model: {model}",
    ]
