"""Names that commands had in version 0.1: they still work in 0.2, with a line that names the new one."""

from collections.abc import Sequence

from robot.console.program_output import complain

LAST_VERSION = "0.2"
OLD_NAMES = {
    "doctor": "check --computer",
    "bridge": "view --ros2",
    "servo scan": "devices --discover none",
    "ft scan": "devices --port none",
    "ft watch": "force watch",
    "ft bias": "force bias",
    "ft identify": "force identify",
    "ft calibrate": "force calibrate",
    "ft": "force",
    "log cut": "log trim",
    "gap alone": "gap diagnose --alone",
    "gap check": "campaign score",
    "sim campaign": "campaign make",
    "sim unseal": "campaign unseal",
}


def with_new_names(arguments: Sequence[str]) -> list[str]:
    """Return a command line with today's name of its command; an old one is answered on stderr."""
    given = list(arguments)
    for old, new in OLD_NAMES.items():  # longer names stand before shorter ones
        words = old.split()
        if given[: len(words)] == words:
            complain(
                f"note: bigant {old} is now bigant {new}; the old name works in version {LAST_VERSION} only"
            )
            return [*new.split(), *given[len(words) :]]
    return given
