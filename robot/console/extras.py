"""How an optional package is installed: in one place, so that every command says the same."""


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra of ours, to be typed in the clone."""
    return f"pip install -e '.[{extra}]'"
