"""``bigant replay``: ticks or bytes of a log through this version's code, and the result as lines."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial

from model.errors import ConfigError
from record.log.reader import LogContents
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.program_output import complain
from robot.console.progress import ProgressLine
from robot.console.table import Column, table_lines
from robot.control.effect_uses import unused_notes
from robot.replay.bus import BusReplay, replay_bus
from robot.replay.compare import Difference, FieldResult
from robot.replay.ticks import Replay, replay_log
from robot.requests.recorded import ReplayRequest

COLUMNS = (
    *(Column(name) for name in ("stage", "field", "unit")),
    Column("tolerance", "s"),
    Column("largest", "s"),
    Column("ticks beyond", "d"),
)


def replay(request: ReplayRequest) -> ExitCode:
    """Replay a log, or do its run again.

    Raises:
        BigantError: The log cannot be read or replayed, or something is wrong before the robot moves.
    """
    if request.drive:
        from robot.replay.drive import drive_again  # and with it all that a run needs

        return drive_again(request)
    for name in ("armed", "virtual_time", "log", "out"):
        if getattr(request, name):
            raise ConfigError(f"--{name.replace('_', '-')}", "goes with --drive only")
    contents = LogContents()
    # of legs that are not driven the estimator is replayed; a controller refuses them by itself
    config = None if request.robot is None else load_robot(request.robot, driven=False)
    if config is not None:
        for note in unused_notes(config.effects):
            complain(note)
    run = replay_bus if request.bus else partial(replay_log, processes=True)
    with ProgressLine(f"replaying {request.path}", contents.progress):
        result = run(
            request.path,
            scale=request.tolerance,
            config=config,
            contents=contents,
            gait=request.gait,
        )
    fields = {**asdict(result), "equal": result.equal}
    print_result(fields, result_lines(result), as_json=request.json)
    return ExitCode.OK if result.equal else ExitCode.VERDICT_FAILED


def result_lines(result: Replay | BusReplay, *, only_beyond: bool = False) -> list[str]:
    """Return a result for a person; on request only those fields that differ too much."""
    lines = [
        *field_table(result.fields, only_beyond=only_beyond),
        *(f"note: {note}" for note in result.notes),
        *([] if result.first is None else [first_line(result.first)]),
    ]
    done = f"{result.ticks} ticks, {result.duration_s:.1f} s"
    if result.wall_s > 0:
        done += f", {result.duration_s / result.wall_s:.0f} times real time"
    if isinstance(result, BusReplay):
        lines += _wire_lines(result)
        done += (
            f"; {result.requests} requests of {result.bytes_sent} bytes as recorded, "
            f"{result.bytes_received} bytes understood"
        )
    elif result.equal:
        same = "all" if result.equal_bits == result.ticks else str(result.equal_bits)
        done += f", {same} of them the same in every bit"
    return [*lines, f"{'equal' if result.equal else 'NOT EQUAL'}: {done}"]


def field_table(fields: Sequence[FieldResult], *, only_beyond: bool = False) -> list[str]:
    """Return stages and fields as a table; on request only those that differ too much."""
    rows = []
    stage = ""
    for field in fields:
        if only_beyond and not field.ticks_beyond:
            continue
        shown = field.stage if field.stage != stage else ""
        stage = field.stage
        tolerance, largest = _tolerance(field.tolerance), _largest(field.largest)
        rows.append((shown, field.name, field.unit, tolerance, largest, field.ticks_beyond))
    return table_lines(COLUMNS, rows)


def first_line(first: Difference) -> str:
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


def _wire_lines(result: BusReplay) -> list[str]:
    wire = result.wire
    if wire is None:
        return []
    return [
        f"first other request: {wire.t_s:.3f} s, {wire.wire}",
        f"  recorded  {wire.recorded_hex}",
        f"            {wire.recorded}",
        f"  today     {wire.sent_hex}",
        f"            {wire.sent}",
        *([f"  differs   {wire.differs}"] if wire.differs else []),
    ]
