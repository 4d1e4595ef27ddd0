"""Exit codes of every command, in one place; which one a stopped run has: ``robot.control.stops``."""

import enum


class ExitCode(enum.IntEnum):
    """What a shell sees.

    ``USAGE`` is argparse's own code; mistakes in files and arguments share it.
    ``INTERRUPTED`` is what shells give to Ctrl-C, 128 and the number of the signal.
    """

    OK = 0
    VERDICT_FAILED = 1
    USAGE = 2
    HARDWARE = 3
    LOG = 4
    INTERRUPTED = 130
