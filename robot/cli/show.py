"""``bigant show``: what a log says, as a table and as pictures."""

import argparse

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def show(options: argparse.Namespace) -> ExitCode:
    """Summarise a log and draw it.

    Raises:
        RecordError: The log cannot be read, or the page cannot be written.
        ConfigError: ``--out`` names no kind of file we write.
    """
    from robot.report.show import ShowRequest, show_log

    return show_log(parsed(options, ShowRequest))
