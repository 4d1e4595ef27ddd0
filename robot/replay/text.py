"""The result of a replay in lines for a person."""

import math
from collections.abc import Sequence

from robot.replay.bus import BusReplay
from robot.replay.compare import Difference, FieldResult
from robot.replay.ticks import Replay


def replay_lines(result: Replay, *, only_beyond: bool = False) -> list[str]:
    """Return the result of a replay of ticks; on wish only those fields that differ too much."""
    lines = _table(result.fields, only_beyond=only_beyond)
    lines += [f"note: {note}" for note in result.notes]
    done = f"{result.ticks} ticks, {_speed(result.duration_s, result.wall_s)}"
    if result.first is not None:
        return [*lines, _first(result.first), f"NOT EQUAL: {done}"]
    same = "all" if result.equal_bits == result.ticks else str(result.equal_bits)
    return [*lines, f"equal: {done}, {same} of them the same in every bit"]


def bus_lines(result: BusReplay, *, only_beyond: bool = False) -> list[str]:
    """Return the result of a replay of bytes; on wish only those fields that differ too much."""
    lines = _table(result.fields, only_beyond=only_beyond)
    lines += [f"note: {note}" for note in result.notes]
    done = (
        f"{result.ticks} ticks, {_speed(result.duration_s, result.wall_s)}; {result.requests} requests "
        f"of {result.bytes_sent} bytes as recorded, {result.bytes_received} bytes understood"
    )
    if result.first is not None:
        lines.append(_first(result.first))
    if result.wire is not None:
        wire = result.wire
        lines += [
            f"first other request: {wire.t_s:.3f} s, {wire.wire}",
            f"  recorded  {wire.recorded_hex}",
            f"            {wire.recorded}",
            f"  today     {wire.sent_hex}",
            f"            {wire.sent}",
        ]
        if wire.differs:
            lines.append(f"  differs   {wire.differs}")
    return [*lines, f"{'equal' if result.equal else 'NOT EQUAL'}: {done}"]


def _speed(duration_s: float, wall_s: float) -> str:
    times = f", {duration_s / wall_s:.0f} times real time" if wall_s > 0 else ""
    return f"{duration_s:.1f} s{times}"


def _table(fields: Sequence[FieldResult], *, only_beyond: bool) -> list[str]:
    lines = [
        f"{'stage':<12}{'field':<17}{'unit':<12}{'tolerance':>10}{'largest':>11}{'ticks beyond':>14}"
    ]
    stage = ""
    for field in fields:
        if only_beyond and not field.ticks_beyond:
            continue
        shown = field.stage if field.stage != stage else ""
        stage = field.stage
        tolerance = "none" if field.tolerance == 0 else f"{field.tolerance:.0e}"
        # a value against none at all has no difference in numbers
        largest = f"{field.largest:.2g}" if math.isfinite(field.largest) else "absent"
        lines.append(
            f"{shown:<12}{field.name:<17}{field.unit:<12}{tolerance:>10}{largest:>11}"
            f"{field.ticks_beyond:>14}"
        )
    return lines


def _first(first: Difference) -> str:
    unit = f" {first.unit}" if first.unit else ""
    element = f" of {first.element}" if first.element else ""
    return (
        f"first difference: {first.t_s:.3f} s (tick {first.index}), {first.stage}, "
        f"{first.name}{element}: recorded {first.recorded}{unit}, today {first.replayed}{unit}"
    )
