"""Which module answers which command: ``bigant GROUP ACTION`` and ``bigant COMMAND``.

A module has ``add_arguments(parser)``, ``run(options)`` and no heavy imports at its top. Only the
module that is asked for is imported, so that ``bigant --help`` answers at once.
"""

import argparse
import importlib
from collections.abc import Sequence
from dataclasses import dataclass

from robot.cli.examples import EXAMPLES
from robot.console.exit_codes import ExitCode

EXAMPLES_HEAD = "examples:"


@dataclass(frozen=True, slots=True)
class Command:
    """One command line.

    Attributes:
        words: ``("model", "run")`` or ``("check",)``.
        module: Where it is written.
        help: What it is for.
    """

    words: tuple[str, ...]
    module: str
    help: str


GROUP_HELP = (
    ("model", "the model of slipping, without a robot"),
    ("robot", "the robot file for other programs"),
    ("log", "look at, mend, cut, merge and export logs"),
    ("gap", "where a simulator differs from measured runs, and why"),
    ("servo", "the servos one by one: scan, set up, back up, watch"),
    ("sim", "virtual hardware, its faults, and a robot that is wrong on purpose"),
    ("ft", "the force-torque sensors: find, watch, bias, calibrate"),
)

COMMANDS = (
    Command(("model", "run"), "robot.cli.model.run", "a named system through the model, drawn"),
    Command(
        ("model", "sensitivity"),
        "robot.cli.model.sensitivity",
        "naive against fitted parameters on logs",
    ),
    Command(
        ("model", "figures"),
        "robot.cli.model.figures",
        "our version of the paper's figures and tables",
    ),
    Command(
        ("odom",), "robot.cli.odom", "odometry and foot forces from a log; 'odom tune' its noise"
    ),
    Command(("robot", "export"), "robot.cli.robot.export", "the robot file as URDF or MJCF"),
    Command(
        ("replay",), "robot.cli.replay", "a recorded run again, as a test: step, drivers or robot"
    ),
    Command(("log", "info"), "robot.cli.log.info", "duration, rate, topics, versions, damage"),
    Command(("log", "repair"), "robot.cli.log.repair", "a proper file of a cut or damaged log"),
    Command(("log", "cut"), "robot.cli.log.cut", "a piece of a log"),
    Command(("log", "merge"), "robot.cli.log.merge", "logs of one robot, one behind the other"),
    Command(("log", "export"), "robot.cli.log.export", "tables, trials and trajectories of a log"),
    Command(
        ("gap", "check"),
        "robot.cli.gap.check",
        "diagnose a withheld campaign, open the seal, count",
    ),
    Command(
        ("gap", "diagnose"), "robot.cli.gap.diagnose", "where, which effect, how far it shrinks"
    ),
    Command(("gap", "alone"), "robot.cli.gap.alone", "how far an explanation comes by itself"),
    Command(
        ("gap", "apply"),
        "robot.cli.gap.apply",
        "a diagnosis into a corrected robot file, measured again",
    ),
    Command(
        ("gap", "next"), "robot.cli.gap.next", "which run would tell the remaining causes apart"
    ),
    Command(
        ("gap", "effects"), "robot.cli.gap.effects", "every effect a simulator can add to itself"
    ),
    Command(("import",), "robot.cli.import_", "measured data as a log or a trial, checked"),
    Command(("servo", "scan"), "robot.cli.servo.scan", "who answers at which baud rate"),
    Command(
        ("servo", "setup"), "robot.cli.servo.setup", "bring servos into the robot file's settings"
    ),
    Command(
        ("servo", "backup"), "robot.cli.servo.backup", "everything the servos keep, into a file"
    ),
    Command(("servo", "restore"), "robot.cli.servo.restore", "a backup back into the servos"),
    Command(("servo", "zero"), "robot.cli.servo.zero", "the servo_zero line of the robot file"),
    Command(("servo", "watch"), "robot.cli.servo.watch", "live table, round trips, counters"),
    Command(
        ("servo", "reboot"), "robot.cli.servo.reboot", "reboot, and keep the cause of the error"
    ),
    Command(("view",), "robot.cli.view", "watch a run, live or from its log"),
    Command(("bridge",), "robot.cli.bridge", "a live run or a log as ROS 2 topics"),
    Command(("doctor",), "robot.cli.doctor", "is this computer set up, and what to do if not"),
    Command(("completion",), "robot.cli.completion", "completion script for bash, zsh or fish"),
    Command(("check",), "robot.cli.check", "pre-flight list: is this robot fit to walk?"),
    Command(("sim", "serve"), "robot.cli.sim.serve", "serve virtual devices until Ctrl-C"),
    Command(("sim", "faults"), "robot.cli.sim.faults", "list the faults that --scenario can hold"),
    Command(
        ("sim", "effects"), "robot.cli.sim.effects", "what can be made wrong with the virtual robot"
    ),
    Command(
        ("sim", "run"), "robot.cli.sim.run", "a walk of the virtual robot with effects, as a trial"
    ),
    Command(
        ("sim", "campaign"), "robot.cli.sim.campaign", "many trials of a scenario file, in parallel"
    ),
    Command(("sim", "unseal"), "robot.cli.sim.unseal", "open the labels of a sealed campaign"),
    Command(("sim", "render"), "robot.cli.sim.render", "a picture or video of a log or trial"),
    Command(("ft", "scan"), "robot.cli.ft.scan", "find wireless force-torque units"),
    Command(("ft", "watch"), "robot.cli.ft.watch", "live readings, state, losses and clock"),
    Command(("ft", "bias"), "robot.cli.ft.bias", "measure what is read with no contact"),
    Command(
        ("ft", "calibrate"),
        "robot.cli.ft.calibrate",
        "offset, leg gravity and cross-talk from logs",
    ),
)

Parsers = argparse._SubParsersAction  # what add_subparsers returns has no public name


def add_commands(
    commands: "Parsers[argparse.ArgumentParser]", arguments: Sequence[str] | None, epilog: str
) -> None:
    """Add all commands to the parser; arguments only to the one that is asked for.

    Args:
        commands: Where they are added.
        arguments: What was typed; None to add the arguments of all of them.
        epilog: Last lines of each command's help, below its examples.
    """
    groups = {}
    for name, words in GROUP_HELP:
        group = commands.add_parser(name, help=words, description=f"{words}.".capitalize())
        groups[name] = group.add_subparsers(dest="action", required=True, metavar="ACTION")
    for command in COMMANDS:
        parent = commands if len(command.words) == 1 else groups[command.words[0]]
        parser = parent.add_parser(
            command.words[-1],
            help=command.help,
            epilog=epilog_of(command.words, epilog),
            formatter_class=HelpFormatter,
        )
        parser.set_defaults(module=command.module)
        if arguments is None or tuple(arguments[: len(command.words)]) == command.words:
            module = importlib.import_module(command.module)
            parser.description = module.__doc__.split("\n\n", 1)[-1] if module.__doc__ else None
            module.add_arguments(parser)


class HelpFormatter(argparse.HelpFormatter):
    """Keeps the lines of examples; fills everything else."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if not text.startswith(EXAMPLES_HEAD):
            return super()._fill_text(text, width, indent)
        examples, _, rest = text.partition("\n\n")
        return f"{examples}\n\n{super()._fill_text(rest, width, indent)}"


def epilog_of(words: tuple[str, ...], epilog: str) -> str:
    """Return the end of a command's help: its examples, then ``epilog``."""
    lines = "\n".join(f"  {line}" for line in EXAMPLES.get(words, ()))
    return f"{EXAMPLES_HEAD}\n{lines}\n\n{epilog}"


def run_command(options: argparse.Namespace) -> ExitCode:
    """Run the command that was asked for."""
    code: ExitCode = importlib.import_module(options.module).run(options)
    return code
