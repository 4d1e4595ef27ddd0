"""``bigant replay``: a recorded run again, as a test.

Plain, the recorded inputs go through today's controller and every stage's output is compared with the
recorded one. With --bus the recorded bytes of both devices go through today's drivers, which have to
send what they sent then. With --drive the robot does the same run again, and the new measurements are
compared with the old. Exit code 0: equal (--drive: driven); 1: not.
"""

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import ConfigError
from robot.console.arguments import seed
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from robot.replay.compare import Difference, FieldResult
    from robot.replay.ticks import Replay


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--tolerance", type=_scale, default=1.0, metavar="X",
        help="factor on all tolerances (1); 0 asks for the same bits",
    )  # fmt: skip
    parser.add_argument(
        "--robot", type=Path, metavar="FILE", help="try this robot file instead of the log's"
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument(
        "--bus", action="store_true",
        help="replay the recorded bytes through the drivers (log: bigant drive --record-bytes)",
    )  # fmt: skip
    kind.add_argument("--drive", action="store_true", help="do the run again on a robot")
    again = parser.add_argument_group("with --drive")
    again.add_argument("--hardware", default="virtual", metavar="virtual|PORT",
                       help="virtual (default), or the serial port of the servo bus")  # fmt: skip
    again.add_argument("--armed", action="store_true", help="allow torque on real hardware")
    again.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]|none",
                       help="force-torque unit (default: robot file)")  # fmt: skip
    again.add_argument("--virtual-time", action="store_true", help="as fast as the computer goes")
    again.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    again.add_argument("--log", type=Path, metavar="FILE", help="the new log (default: runs/...)")
    again.add_argument("--out", type=Path, metavar="FILE",
                       help="page with the pictures (default: beside the new log)")  # fmt: skip


def _scale(text: str) -> float:
    value = float(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be 0 or a positive number, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Replay a log.

    Raises:
        BigantError: The log cannot be read or replayed.
    """
    if options.drive:
        from robot.replay.drive import drive_again

        return drive_again(options)
    for name in ("armed", "virtual_time", "log", "out"):
        if getattr(options, name):
            raise ConfigError(f"--{name.replace('_', '-')}", "goes with --drive only")
    if options.bus:
        from robot.replay.bus import replay_bus_command

        return replay_bus_command(options)
    from record.log.reader import LogContents
    from robot.config.robot_file import load_robot
    from robot.console.progress import ProgressLine
    from robot.control.effect_uses import unused_notes
    from robot.replay.ticks import replay_log

    contents = LogContents()
    config = None if options.robot is None else load_robot(options.robot)
    if config is not None:
        for note in unused_notes(config.effects):
            complain(note)
    with ProgressLine(f"replaying {options.path}", contents.progress):
        found = replay_log(options.path, scale=options.tolerance, config=config, contents=contents)
    if options.json:
        print(json.dumps(as_json(found), indent=2))
    else:
        for line in replay_lines(found):
            print(line)
    return ExitCode.OK if found.equal else ExitCode.VERDICT_FAILED


def replay_table(fields: "Sequence[FieldResult]", *, only_beyond: bool = False) -> list[str]:
    """Return stages and fields as a table; on wish only those that differ too much."""
    lines = [
        f"{'stage':<16}{'field':<17}{'unit':<12}{'tolerance':>10}{'largest':>11}{'ticks beyond':>14}"
    ]
    stage = ""
    for field in fields:
        if only_beyond and not field.ticks_beyond:
            continue
        shown = field.stage if field.stage != stage else ""
        stage = field.stage
        lines.append(
            f"{shown:<16}{field.name:<17}{field.unit:<12}{_tolerance(field.tolerance):>10}"
            f"{_largest(field.largest):>11}{field.ticks_beyond:>14}"
        )
    return lines


def replay_lines(found: "Replay", *, only_beyond: bool = False) -> list[str]:
    """Return the result for a person; on wish only those fields that differ too much."""
    lines = [
        *replay_table(found.fields, only_beyond=only_beyond),
        *(f"note: {note}" for note in found.notes),
    ]
    speed = f", {found.duration_s / found.wall_s:.0f} times real time" if found.wall_s > 0 else ""
    done = f"{found.ticks} ticks, {found.duration_s:.1f} s{speed}"
    if found.first is not None:
        return [*lines, first_line(found.first), f"NOT EQUAL: {done}"]
    same = "all" if found.equal_bits == found.ticks else str(found.equal_bits)
    return [*lines, f"equal: {done}, {same} of them the same in every bit"]


def first_line(first: "Difference") -> str:
    """Return the first difference in words."""
    unit = f" {first.unit}" if first.unit else ""
    element = f" of {first.element}" if first.element else ""
    return (
        f"first difference: {first.t_s:.3f} s (tick {first.index}), {first.stage}, "
        f"{first.name}{element}: recorded {first.recorded}{unit}, today {first.replayed}{unit}"
    )


def _tolerance(value: float) -> str:
    return "none" if value == 0 else f"{value:.0e}"


def _largest(value: float) -> str:
    """A value against none at all has no difference in numbers."""
    return f"{value:.2g}" if math.isfinite(value) else "absent"


def as_json(found: "Replay") -> object:
    """Return the result for ``json.dumps``; what is infinite or not a number is null."""
    from robot.console.json_output import plain

    return plain({**asdict(found), "equal": found.equal})
