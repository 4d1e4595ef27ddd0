"""The one command, ``bigant``: signals, errors and exit codes; ``robot.cli.commands`` has the commands."""

import argparse
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

from model.errors import BigantError, BusError, ForceStreamError, RecordError
from robot.cli.command_parser import CommandParser
from robot.cli.commands import EPILOG, add_commands, overview, run_command
from robot.cli.help_pages import page_hint
from robot.cli.old_names import with_new_names
from robot.console.exit_codes import ExitCode
from robot.console.printable import printable_output
from robot.console.program_output import complain, stop_output
from robot.console.progress import show_compiling
from robot.console.second_compiler import compile_with_two
from robot.console.shipped import with_pages


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # and not ignored, as nohup does
            signal.signal(number, _leave)
    sys.exit(run(arguments))


class EndSignal(KeyboardInterrupt):
    """A signal other than Ctrl-C asked the program to end."""

    def __init__(self, number: int) -> None:
        self.number = number


def _leave(number: int, _frame: FrameType | None) -> NoReturn:
    """Leave through every ``finally``, so that torque is switched off and no half-written file stays."""
    raise EndSignal(number)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Raises:
        SystemExit: The arguments make no sense (argparse), or help was asked for.
    """
    given = with_new_names(sys.argv[1:] if arguments is None else arguments)
    options = _parser(given).parse_args(given)
    show_compiling()
    compile_with_two()
    words = " ".join(
        ["bigant", options.command, *([options.action] if "action" in options else [])]
    )
    try:
        with printable_output():
            code = int(run_command(options))
        sys.stdout.flush()  # here, so that a full disk is reported like any other mistake
        return code
    except EndSignal as end:
        complain(f"{words}: ended by {signal.Signals(end.number).name}")
        return 128 + end.number
    except KeyboardInterrupt:  # drive, and every command that listens, handles it itself
        complain(f"\n{words}: interrupted")
        return int(ExitCode.INTERRUPTED)
    except BigantError as error:
        complain(f"{words}: {with_pages(f'{error}{page_hint(error)}')}")
        return int(_code_of(error))
    except BrokenPipeError:  # the reader of our output went away, as with `| head`
        stop_output()
        return int(ExitCode.OK)
    except (
        OSError
    ) as error:  # a full disk, for example; commands report the errors that they expect
        complain(
            f"{words}: {error.strerror or error}{f': {error.filename}' if error.filename else ''}"
        )
        stop_output()
        return int(ExitCode.LOG)


def _code_of(error: BigantError) -> ExitCode:
    if isinstance(error, BusError | ForceStreamError):
        return ExitCode.HARDWARE
    if isinstance(error, RecordError):
        return ExitCode.LOG
    return ExitCode.USAGE


class _Version(argparse.Action):
    """Print versions; nothing is imported for it unless it is asked for."""

    def __init__(self, option_strings: Sequence[str], dest: str, help: str) -> None:  # noqa: A002
        super().__init__(option_strings, dest, nargs=0, help=help, default=argparse.SUPPRESS)

    def __call__(self, parser: argparse.ArgumentParser, *_: object, **__: object) -> None:
        from robot.console.installed import version_lines

        print("\n".join(version_lines()))
        parser.exit()


def full_parser() -> argparse.ArgumentParser:
    """Return the parser with the arguments of every command: for completion, reference and tests."""
    return _parser(None)


def _parser(arguments: Sequence[str] | None) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = CommandParser(prog="bigant", overview=overview())
    parser.add_argument("--version", action=_Version, help="versions of what matters, and exit")
    add_commands(parser, arguments, EPILOG)
    return parser
