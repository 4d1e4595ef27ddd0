"""The table of all commands and their parsers: ``bigant COMMAND`` and ``bigant GROUP ACTION``.

What a command is asked for is a request (``robot.requests``): its class is named after the command, its
fields are the options, its docstring is the help. Only the module of the group that was typed is imported,
so ``bigant --help`` answers at once.
"""

import argparse
import importlib
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

from record.earlier_file import earlier_files
from robot.cli.command_parser import EXAMPLES_HEAD, CommandParser, HelpFormatter
from robot.cli.examples import EXAMPLES
from robot.console.arguments import WORK, WRITES, add_arguments, parsed
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain

REQUEST = "_request"  # of parsed arguments: the request of the command that was typed
_Parsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # has no public name
EPILOG = "exit codes: 0 ok, 1 failed verdict, 2 usage, 3 hardware, 4 log, 130 Ctrl-C"
OVERWRITE_HELP = "replace earlier files (default: they are kept as NAME.1.EXT)"
# The modules of the commands of one word: about a robot or this computer, or about what was recorded.
SINGLE = "single"
RECORDED = dict.fromkeys(("show", "report", "odom", "replay", "import", "view"), "recorded")

# Commands and groups as ``bigant --help`` lists them.
HEADINGS = {
    "start here": ("drive", "show", "examples"),
    "robot": ("robot", "check", "bringup"),
    "devices": ("devices", "servo", "force"),
    "logs": ("log", "report", "import", "replay", "view"),
    "analysis": ("odom", "gap", "model"),
    "advanced": ("sim", "campaign", "completion"),
}

GROUP_HELP = {
    "robot": "robot files: show one, start one, export URDF or MJCF",
    "servo": "one servo at a time: set up, back up, zero, watch, jog",
    "force": "force-torque sensors: watch, bias, identify, calibrate",
    "log": "inspect, export, trim, merge and repair logs",
    "gap": "where a simulator differs from measured runs, and why",
    "model": "the slip model, without a robot",
    "sim": "virtual devices, their faults, and faulty virtual robots",
    "campaign": "how often is the diagnosis right? many blind cases",
}

# The first command of a group is the one that most people want.
COMMANDS = {
    "drive": "walk a gait; the robot is virtual unless you name a port",
    "show": "what happened in a log: a table and a page of pictures",
    "examples": "list or copy robot files and scripts to start from",
    "robot show": "check a robot file: stability, slip, speed, torque",
    "robot new": "write a commented robot file to start from",
    "robot export": "write the robot file as URDF or MJCF",
    "check": "is this robot ready to walk? is this computer?",
    "bringup": "the first day with a real robot, step by step",
    "devices": "list ports, servos at each baud rate, force-torque units",
    "servo watch": "live table, round trips, counters",
    "servo setup": "set servos up as the robot file says",
    "servo zero": "find the servo_zero line of the robot file",
    "servo jog": "turn one leg a little, see which one moves",
    "servo backup": "save everything the servos store to a file",
    "servo restore": "write a backup back to the servos",
    "servo reboot": "reboot, and keep the cause of the error",
    "force watch": "live readings, state, losses and clock",
    "force bias": "measure the readings without contact",
    "force identify": "which transducer each foot presses, and how",
    "force calibrate": "offset, leg gravity and cross-talk from logs",
    "log info": "duration, rate, topics, versions, damage",
    "log export": "tables, trials and trajectories of a log",
    "log trim": "keep one piece of a log",
    "log merge": "join logs of one robot in order of time",
    "log repair": "make a readable log of a damaged one",
    "report": "one page of a day: every run, faults, new gaps",
    "import": "your CSV, Parquet, NPZ or ROS 2 bag as a log or trial",
    "replay": "run a log again through today's code, as a test",
    "view": "watch a run: Foxglove, Rerun, terminal or ROS 2",
    "odom": "odometry and foot forces from a log",
    "gap demo": "inject a known fault, diagnose it, compare the answer",
    "gap diagnose": "find the cause of the gap and how much it explains",
    "gap apply": "write a diagnosis into the robot file, measure again",
    "gap next": "which run settles what a diagnosis left open",
    "gap effects": "list every effect that a diagnosis can name",
    "model run": "simulate and draw a named system",
    "model sensitivity": "compare naive and fitted parameters on logs",
    "model figures": "our version of the paper's figures and tables",
    "sim run": "one walk of a virtual robot with chosen faults",
    "sim serve": "serve virtual devices until Ctrl-C",
    "sim effects": "list what can be wrong with the virtual robot",
    "sim faults": "list the device faults that --scenario can hold",
    "sim realities": "list the variants of the virtual robot",
    "sim render": "a picture or video of a log or trial",
    "campaign make": "many trials of a scenario file, in parallel",
    "campaign score": "diagnose a blind campaign, unseal it, count",
    "campaign unseal": "open the labels of a sealed campaign",
    "completion": "tab completion for bash, zsh or fish",
}


def overview() -> str:
    """Return what ``bigant --help`` prints; it fits in a terminal of 80 x 24."""
    return "\n".join(
        (
            "usage: bigant COMMAND ...  (one in full: bigant COMMAND --help), or --version",
            "Drive, log and model legged robots that slip; find where a simulator is wrong.",
            *_listed(),
            EPILOG,
            "",
        )
    )


def _listed() -> Iterator[str]:
    for heading, names in HEADINGS.items():
        for at, name in enumerate(names):
            text = GROUP_HELP.get(name) or COMMANDS[name]
            yield f"{'' if at else heading:<12}{name:<12}{text}"


def add_commands(
    parser: argparse.ArgumentParser, arguments: Sequence[str] | None, epilog: str
) -> None:
    """Add all commands to the parser; arguments only to the one that was typed.

    Args:
        parser: Of ``bigant``.
        arguments: What was typed; None to add the arguments of all of them.
        epilog: Last lines of each command's help, below its examples.
    """
    commands = parser.add_subparsers(  # type: ignore[call-overload]
        dest="command", required=True, metavar="COMMAND", parser_class=_ParserOf(arguments)
    )
    parents = {"": commands}
    for command, text in COMMANDS.items():
        *group, name = words = command.split()
        parent = parents.get("".join(group)) or _add_group(commands, parents, *group)
        if arguments is not None and not set(group) <= set(arguments):
            continue
        first, *others = EXAMPLES.get(command, ("",))
        examples = "\n".join((EXAMPLES_HEAD, *(f"  {line}" for line in others)))
        own = parent.add_parser(
            name,
            help=text,
            epilog=f"{examples}\n\n{epilog}" if others else epilog,
            formatter_class=HelpFormatter,
            example=first,
        )
        if arguments is None or list(arguments[: len(words)]) == words:
            request = request_of(command)
            own.set_defaults(**{REQUEST: request})
            own.description = (request.__doc__ or "").split("\n\n", 1)[-1]
            add_arguments(own, request)
            if getattr(request, WRITES):
                own.add_argument("--overwrite", action="store_true", help=OVERWRITE_HELP)


class _ParserOf:
    """Makes the parser of a command or group; one for all commands that were not typed.

    Only their names matter, and each parser takes a tenth of a millisecond to make, as its few words are
    looked up in catalogues of translations on disk.
    """

    def __init__(self, arguments: Sequence[str] | None) -> None:
        self._arguments = arguments
        self._not_typed = argparse.ArgumentParser(add_help=False)

    def __call__(self, *, prog: str, **words: Any) -> argparse.ArgumentParser:
        """Return the parser of "bigant COMMAND" or "bigant GROUP"."""
        _, name = prog.split()
        if self._arguments is None or name in self._arguments or name in GROUP_HELP:
            return CommandParser(prog=prog, **words)
        return self._not_typed


def request_of(command: str) -> type[Any]:
    """Import the class of what a command such as "servo zero" is asked for."""
    *group, _ = words = command.split()
    of_one_word = RECORDED.get(command, SINGLE)
    module = importlib.import_module(f"robot.requests.{''.join(group) or of_one_word}")
    kind: type[Any] = getattr(module, "".join(map(str.capitalize, words)) + "Request")
    return kind


def _add_group(commands: _Parsers, parents: dict[str, _Parsers], name: str) -> _Parsers:
    text = GROUP_HELP[name]
    first = next(command for command in COMMANDS if command.startswith(f"{name} "))
    group = commands.add_parser(
        name,
        help=text,
        description=f"{text[:1].upper()}{text[1:]}{'' if text.endswith('?') else '.'}",
        example=EXAMPLES[first][0],
    )
    parents[name] = group.add_subparsers(dest="action", required=True, metavar="ACTION")
    return parents[name]


def run_command(options: argparse.Namespace) -> ExitCode:
    """Do what the command that was typed was asked for."""
    request = getattr(options, REQUEST)
    module, _, function = getattr(request, WORK).partition(":")
    work = getattr(importlib.import_module(f"robot.{module}"), function)
    with earlier_files(overwrite=vars(options).get("overwrite", False), notify=complain):
        code: ExitCode = work(parsed(options, request))
    return code
