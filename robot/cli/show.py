"""``bigant show``: what a log says, as a table and as pictures."""

import argparse

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def show(options: argparse.Namespace) -> ExitCode:
    """Summarise a log and draw it."""
    from robot.report.show import ShowRequest, show_log

    return show_log(parsed(options, ShowRequest))
