"""The table of all commands and their parsers: ``bigant COMMAND`` and ``bigant GROUP ACTION``.

What a command is asked for is a request (``robot.requests``): its class is named after the command, its
fields are the options, its docstring is the help. Only the module of the group that was typed is imported,
so ``bigant --help`` answers at once.
"""

import argparse
import difflib
import importlib
import re
from collections.abc import Sequence
from typing import Any, NoReturn, TypeAlias

from record.earlier_file import earlier_files
from robot.cli.examples import EXAMPLES
from robot.console.arguments import WORK, WRITES, add_arguments, parsed
from robot.console.exit_codes import ExitCode
from robot.console.printable import printable
from robot.console.program_output import complain

EXAMPLES_HEAD = "examples:"
# Of parsed arguments: the parser of the command that was typed, and its request.
OWN, REQUEST = "_parser", "_request"
_Parsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # has no public name
OVERWRITE_HELP = "replace earlier files (default: they are kept as NAME.1.EXT)"
SINGLE = (
    "single"  # the module of the commands of one word, but for those asked of what was recorded
)
RECORDED = dict.fromkeys(("show", "odom", "replay", "import", "view", "bridge"), "recorded")


GROUP_HELP = {
    "model": "the model of slipping, without a robot",
    "robot": "the robot file: looked at, begun, for other programs",
    "log": "look at, repair, cut, merge and export logs",
    "gap": "where a simulator differs from measured runs, and why",
    "servo": "the servos one by one: scan, set up, back up, watch",
    "sim": "virtual hardware, its faults, and a deliberately faulty virtual robot",
    "ft": "the force-torque sensors: find, watch, bias, calibrate",
}

COMMANDS = {
    "drive": "walk a gait, on virtual hardware by default",
    "show": "summary table and pictures of a log",
    "devices": "ports, servos at each baud rate, force-torque units",
    "model run": "a named system through the model, drawn",
    "model sensitivity": "naive against fitted parameters on logs",
    "model figures": "our version of the paper's figures and tables",
    "odom": "odometry and foot forces from a log; 'odom tune' its noise",
    "robot show": "a robot file as the model walks it, and what is wrong",
    "robot new": "begin a robot file: commented, and of a robot that walks",
    "robot export": "the robot file as URDF or MJCF",
    "replay": "a recorded run again, as a test: step, drivers or robot",
    "log info": "duration, rate, topics, versions, damage",
    "log repair": "a proper file of a cut or damaged log",
    "log cut": "a piece of a log",
    "log merge": "logs of one robot, one behind the other",
    "log export": "tables, trials and trajectories of a log",
    "gap check": "diagnose a withheld campaign, open the seal, count",
    "gap diagnose": "where, which effect, how far it shrinks",
    "gap alone": "how far an explanation comes by itself",
    "gap apply": "a diagnosis into a corrected robot file, measured again",
    "gap next": "which run would tell the remaining causes apart",
    "gap effects": "every effect a simulator can add to itself",
    "import": "measured data as a log or a trial, checked",
    "servo scan": "who answers at which baud rate",
    "servo setup": "bring servos into the robot file's settings",
    "servo backup": "everything the servos keep, into a file",
    "servo restore": "a backup back into the servos",
    "servo zero": "the servo_zero line of the robot file",
    "servo watch": "live table, round trips, counters",
    "servo jog": "turn one leg a little, see which one moves",
    "servo reboot": "reboot, and keep the cause of the error",
    "view": "watch a run, live or from its log",
    "bridge": "a live run or a log as ROS 2 topics",
    "doctor": "is this computer set up, and what to do if not",
    "examples": "robot files and scripts to begin with, listed or copied",
    "completion": "completion script for bash, zsh or fish",
    "check": "pre-flight list: is this robot fit to walk?",
    "bringup": "the first day with a real robot, step by step",
    "sim serve": "serve virtual devices until Ctrl-C",
    "sim faults": "list the faults that --scenario can hold",
    "sim effects": "what can be made wrong with the virtual robot",
    "sim realities": "the ways in which the virtual robot can be built",
    "sim run": "a walk of the virtual robot with effects, as a trial",
    "sim campaign": "many trials of a scenario file, in parallel",
    "sim unseal": "open the labels of a sealed campaign",
    "sim render": "a picture or video of a log or trial",
    "ft scan": "find wireless force-torque units",
    "ft watch": "live readings, state, losses and clock",
    "ft bias": "measure what is read with no contact",
    "ft identify": "which transducer each foot presses, and how",
    "ft calibrate": "offset, leg gravity and cross-talk from logs",
}


class CommandParser(argparse.ArgumentParser):
    """Takes no abbreviations (``--arm`` must not arm a robot) and suggests what a mistake was near to."""

    def __init__(self, **words: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **words})
        self.set_defaults(**{OWN: self})

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Parse; what is left over is a mistake, and the command that was typed answers it."""
        options, left = self.parse_known_args(args, namespace)
        own: CommandParser = vars(options).pop(OWN)
        if left:
            unknown = [word for word in left if word.startswith("-")]
            near = own.near(unknown[0]) if unknown else ""
            own.error(f"unrecognized arguments: {' '.join(left)}{near}")
        return options

    def near(self, option: str) -> str:
        """Return a question for an option that is nearly one of this command's; empty otherwise."""
        known = [name for action in self._actions for name in action.option_strings]
        near = difflib.get_close_matches(option.split("=")[0], known, n=1)
        return f"; did you mean {near[0]}?" if near else ""

    def error(self, message: str) -> NoReturn:
        """Exit with usage and the mistake in words."""
        for action in self._actions:
            if not isinstance(action, argparse._SubParsersAction):
                continue
            names = sorted(action.choices)
            if f"required: {action.metavar}" in message:
                message += f"; {action.metavar} is one of: {', '.join(names)}"
            if wrong := re.search(r"invalid choice: '([^']*)'", message):
                near = difflib.get_close_matches(wrong.group(1), names, n=1)
                message += f"; did you mean {near[0]}?" if near else ""
        super().error(printable(re.sub(r"invalid _?(\w+?)_? value", r"invalid \1 value", message)))


class HelpFormatter(argparse.HelpFormatter):
    """Keeps the lines of examples; fills everything else."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if not text.startswith(EXAMPLES_HEAD):
            return super()._fill_text(text, width, indent)
        examples, _, rest = text.partition("\n\n")
        return f"{examples}\n\n{super()._fill_text(rest, width, indent)}"


def add_commands(
    parser: argparse.ArgumentParser, arguments: Sequence[str] | None, epilog: str
) -> None:
    """Add all commands to the parser; arguments only to the one that was typed.

    Args:
        parser: Of ``bigant``.
        arguments: What was typed; None to add the arguments of all of them.
        epilog: Last lines of each command's help, below its examples.
    """
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    parents = {"": commands}
    for command, text in COMMANDS.items():
        *group, name = words = command.split()
        parent = parents.get("".join(group)) or _add_group(commands, parents, *group)
        examples = "\n".join(f"  {line}" for line in EXAMPLES.get(command, ()))
        own = parent.add_parser(
            name,
            help=text,
            epilog=f"{EXAMPLES_HEAD}\n{examples}\n\n{epilog}",
            formatter_class=HelpFormatter,
        )
        if arguments is None or list(arguments[: len(words)]) == words:
            request = request_of(command)
            own.set_defaults(**{REQUEST: request})
            own.description = (request.__doc__ or "").split("\n\n", 1)[-1]
            add_arguments(own, request)
            if getattr(request, WRITES):
                own.add_argument("--overwrite", action="store_true", help=OVERWRITE_HELP)


def request_of(command: str) -> type[Any]:
    """Import the class of what a command such as "servo zero" is asked for."""
    *group, _ = words = command.split()
    of_one_word = RECORDED.get(command, SINGLE)
    module = importlib.import_module(f"robot.requests.{''.join(group) or of_one_word}")
    kind: type[Any] = getattr(module, "".join(map(str.capitalize, words)) + "Request")
    return kind


def _add_group(commands: _Parsers, parents: dict[str, _Parsers], name: str) -> _Parsers:
    text = GROUP_HELP[name]
    group = commands.add_parser(name, help=text, description=f"{text}.".capitalize())
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
