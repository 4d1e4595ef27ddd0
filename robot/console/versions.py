"""Which versions of what are at work: for ``bigant --version``."""

import platform

from record.log.versions import PACKAGES, version_of


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
