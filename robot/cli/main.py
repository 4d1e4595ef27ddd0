"""The one command, ``bigant``. Parsing only: each subcommand lives in a module of its own.

Modules are imported when their command runs, so that ``bigant --help`` answers at once.
"""

import argparse
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import NoReturn

from model.errors import BigantError, BusError, ForceStreamError, RecordError
from robot.cli.commands import HelpFormatter, add_commands, epilog_of, run_command
from robot.cli.drive import add_arguments as add_drive_arguments
from robot.cli.drive import run as run_drive
from robot.cli.help_pages import page_hint
from robot.cli.parser import CommandParser
from robot.console.compile_line import show_compiling
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain, stop_output

EPILOG = "exit codes: 0 good, 1 a verdict failed, 2 wrong usage or file, 3 hardware, 4 log, 130 interrupted"


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # and not ignored, as nohup does
            signal.signal(number, _leave)
    sys.exit(run(arguments))


class Told(KeyboardInterrupt):
    """Somebody told the program to end by another signal than Ctrl-C."""

    def __init__(self, number: int) -> None:
        self.number = number


def _leave(number: int, _frame: FrameType | None) -> NoReturn:
    """Leave by way of every ``finally``, so that torque goes off and no half a file stays."""
    raise Told(number)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Raises:
        SystemExit: The arguments make no sense (argparse), or help was asked for.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = _parser(given).parse_args(given)
    show_compiling()
    words = " ".join(
        ["bigant", options.command, *([options.action] if "action" in options else [])]
    )
    try:
        code = int(_dispatch(options))
        sys.stdout.flush()  # here, so that a full disk is told like any other mistake
        return code
    except Told as told:
        complain(f"{words}: ended by {signal.Signals(told.number).name}")
        return 128 + told.number
    except KeyboardInterrupt:  # a drive and what listens see to it themselves
        complain(f"\n{words}: interrupted")
        return int(ExitCode.INTERRUPTED)
    except BigantError as error:
        complain(f"{words}: {error}{page_hint(error)}")
        return int(_code_of(error))
    except BrokenPipeError:  # the reader of our output went away, as with `| head`
        stop_output()
        return int(ExitCode.OK)
    except OSError as error:  # no room on the disk, say; what a command expects it words itself
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
        from robot.console.versions import version_lines

        print("\n".join(version_lines()))
        parser.exit()


def _dispatch(options: argparse.Namespace) -> ExitCode:
    if options.command == "drive":
        return run_drive(options)
    if options.command == "show":
        from robot.cli.show import show

        return show(options)
    if options.command == "devices":
        from robot.cli.devices import devices

        return devices(options)
    return run_command(options)


def full_parser() -> argparse.ArgumentParser:
    """Return the parser with the arguments of every command: for completion, reference and tests."""
    return _parser(None)


def _parser(arguments: Sequence[str] | None) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = CommandParser(
        prog="bigant",
        description="Drive, record and model BigANT, on the robot or on virtual hardware.",
        epilog=EPILOG,
    )
    parser.add_argument("--version", action=_Version, help="versions of what matters, and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_drive(commands)
    _add_show(commands)
    _add_devices(commands)
    add_commands(commands, arguments, EPILOG)
    return parser


def _add_drive(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    drive = commands.add_parser(
        "drive",
        help="walk a gait, on virtual hardware unless told otherwise",
        description="Walk a gait and keep a log. Virtual hardware is the default. Real ports are "
        "only listened to unless --armed is given. Ctrl-C stops on all feet, a second Ctrl-C cuts "
        "torque; torque goes off on every way out.",
        epilog=epilog_of(("drive",), EPILOG),
        formatter_class=HelpFormatter,
    )
    add_drive_arguments(drive)


def _add_show(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    show = commands.add_parser(
        "show",
        help="summary table and pictures of a log",
        description="Print a summary of a log (distance, speed, slip, faults, loop) and write a "
        "page with trajectory, body velocity and foot forces, predicted against measured.",
        epilog=epilog_of(("show",), EPILOG),
        formatter_class=HelpFormatter,
    )
    show.add_argument("path", type=Path, metavar="LOG")
    show.add_argument(
        "--out", type=Path, metavar="FILE", help=".html or .png (default: beside the log, .html)"
    )
    show.add_argument("--json", action="store_true", help="the summary as JSON, no picture")


def _add_devices(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    devices = commands.add_parser(
        "devices",
        help="ports, servos at each baud rate, force-torque units",
        description="List serial ports, the servos that answer at each baud rate, and wireless "
        "force-torque units found by discovery. Nothing is written and nothing moves.",
        epilog=epilog_of(("devices",), EPILOG),
        formatter_class=HelpFormatter,
    )
    devices.add_argument(
        "--port", metavar="PORT", help="scan this serial port only (default: every USB port)"
    )
    devices.add_argument(
        "--baud", type=int, metavar="B", help="this baud rate only (default: all eight)"
    )
    devices.add_argument(
        "--discover",
        metavar="ADDRESS[:PORT]|none",
        default="255.255.255.255",
        help="where to ask for force-torque units (default: broadcast on the local network)",
    )
    devices.add_argument("--json", action="store_true", help="the result as JSON")
