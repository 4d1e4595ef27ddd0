"""Exit codes of every command, in one place."""

import enum

from model.values.faults import StopReason


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


_BY_REASON = {
    StopReason.COMPLETED: ExitCode.OK,
    StopReason.OPERATOR: ExitCode.OK,
    StopReason.LOG_FAILED: ExitCode.LOG,
    StopReason.GAIT_REFUSED: ExitCode.USAGE,
}


def exit_code_of(reason: StopReason) -> ExitCode:
    """Return the exit code of a run that ended for a reason."""
    return _BY_REASON.get(reason, ExitCode.HARDWARE)
