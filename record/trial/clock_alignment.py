"""Clocks of files that were recorded apart: aligned by an event that both saw, or by the motion itself.

[file.mocap]                                   # another file of the same run
path = "{name}_mocap.csv"                      # beside the run's table; {name} is that table's
[file.mocap.clock]
by = "correlation"                             # same, offset, event or correlation
signal = "speed"                               # or "yaw_rate": mocap's against the model's of the shafts
columns = ["shaft_HL_rad", "foot_HL_x_m"]      # in its place: a column here and one there

by = "event"
here = { column = "force_HL_z_n", above = 30 } # the first time that it is above, below, or has moved by
there = { column = "body_z_m", moved = 0.005 }
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model.errors import ConfigError, RecordError
from model.motion.differentiate import centred_rate
from model.parameters.toml_table import Table
from model.values.arrays import FloatArray
from record.trial.joined import at_times
from record.trial.lagged_correlation import Lag, best_lag
from record.trial.trial import Trial

SAME, OFFSET, EVENT, CORRELATION = "same", "offset", "event", "correlation"
MOTION, HEIGHT, SPEED, YAW_RATE = SIGNALS = "motion", "height", "speed", "yaw_rate"
TESTS = ("above", "below", "moved")
SMOOTH_S = 0.2  # on either side, over which rates are taken
SHORTEST_PERIOD_S = 0.01
OVERLAP = 0.5  # of the shorter recording
ALIKE = 0.5  # correlation from which on two signals are taken to show one motion
SURE_SIGMAS = 3.0  # by which the best offset must be better than any other
# Body velocity vx, vy, yaw rate and height, (T, 4), that the machine's model predicts from measured shafts.
Predicted = Callable[[Trial], FloatArray]


@dataclass(frozen=True, slots=True)
class ClockEvent:
    """The first time that a column is above or below a limit, or has moved by it from where it began."""

    column: str
    test: str
    limit: float


@dataclass(frozen=True, slots=True)
class FileClock:
    """How the clock of another file lies to that of the run's table.

    Attributes:
        by: ``same``, ``offset``, ``event`` or ``correlation``.
        seconds: What is added to the other's times, for ``offset``.
        here: The event in the run's table.
        there: The same event in the other file.
        signal: One of ``SIGNALS``, where there are no ``columns``; ``motion`` is height and speed.
        columns: A column of the run's table, and one of the other file.
    """

    by: str = SAME
    seconds: float = 0.0
    here: ClockEvent | None = None
    there: ClockEvent | None = None
    signal: str = MOTION
    columns: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ClockAlignment:
    """What is added to the other's times [s], its standard deviation (0: as told), and how it was found."""

    later_s: float
    sd_s: float
    words: str


def read_clock(table: Table) -> FileClock:
    """Read the table [file.NAME.clock].

    Raises:
        ConfigError: Something in it means nothing.
    """
    by = table.word("by", (SAME, OFFSET, EVENT, CORRELATION)) if table.has("by") else SAME
    here, there = (_event(table.table(key)) if by == EVENT else None for key in ("here", "there"))
    columns = table.texts("columns") if table.has("columns") else ()
    if columns and len(columns) != 2:
        raise ConfigError(
            table.name("columns"), "must be a column of the table and one of the file"
        )
    clock = FileClock(
        by=by,
        seconds=table.number("seconds") if by == OFFSET else 0.0,
        here=here,
        there=there,
        signal=table.word("signal", SIGNALS) if table.has("signal") else MOTION,
        columns=columns,
    )
    table.done()
    return clock


def _event(table: Table) -> ClockEvent:
    tests = [name for name in TESTS if table.has(name)]
    if len(tests) != 1:
        raise ConfigError(table.name("column"), f"needs one of {', '.join(TESTS)} next to it")
    event = ClockEvent(table.text("column"), tests[0], table.number(tests[0]))
    table.done()
    return event


def align(
    base: Trial, other: Trial, clock: FileClock, predicted: Predicted | None
) -> ClockAlignment:
    """Return where another file's clock lies.

    Args:
        base: The run's table.
        other: The other file of the same run.
        clock: How to find out.
        predicted: What the machine's model makes of the shafts; None where there is no model.

    Raises:
        RecordError: The event never happens, nothing can be compared, or several offsets fit as well.
    """
    if clock.by == SAME:
        return ClockAlignment(0.0, 0.0, "taken as it is")
    if clock.by == OFFSET:
        return ClockAlignment(clock.seconds, 0.0, f"{clock.seconds:+.6g} s as the map says")
    if clock.by == EVENT:
        assert clock.here is not None, "read with the clock"
        assert clock.there is not None, "read with the clock"
        (here_s, here_sd), (there_s, there_sd) = (
            _first(base, clock.here, "the run's table"),
            _first(other, clock.there, "the file"),
        )
        later_s, sd_s = here_s - there_s, math.hypot(here_sd, there_sd)
        return ClockAlignment(later_s, sd_s, f"{later_s:+.4f} +- {sd_s:.4f} s by the event")
    if clock.columns:
        first, then = (
            _rate(trial, _column(trial, name)[:, None])
            for trial, name in zip((base, other), clock.columns, strict=True)
        )
        name = " and ".join(clock.columns)
    else:
        first, then, name = *_motions(base, other, clock.signal, predicted), clock.signal
    lag, start_s = _lag(base, first, other, then)
    _check(lag, start_s, name)
    later_s = start_s - lag.seconds
    words = (
        f"{later_s:+.4f} +- {lag.sd_s:.4f} s by the correlation of {name} ({lag.correlation:.2f})"
    )
    return ClockAlignment(later_s, lag.sd_s, words)


def _column(trial: Trial, name: str) -> FloatArray:
    for column in trial.columns():
        if column.name == name:
            return column.values
    known = ", ".join(trial.known_columns)
    raise RecordError(f"clock: there is no {name} to align by; there are {known}")


def _first(trial: Trial, event: ClockEvent, where: str) -> tuple[float, float]:
    """When an event happens first, between two samples, and how well that is known [s]."""
    values = _column(trial, event.column)
    known = np.flatnonzero(np.isfinite(values))
    seen = values[known]
    if event.test == "moved":
        seen = np.abs(seen - np.median(seen[:5]))
    happened = seen < event.limit if event.test == "below" else seen > event.limit
    if not happened.any() or happened[0]:
        never = "is so from the beginning" if len(seen) and happened[0] else "never happens"
        raise RecordError(
            f"clock: the event ({event.column} {event.test} {event.limit:g}) {never} in {where}; "
            "choose another limit or column"
        )
    at = int(np.argmax(happened))
    before_s, after_s = trial.time_s[known[at - 1]], trial.time_s[known[at]]
    # it may have been anywhere between the two samples
    return float(before_s + after_s) / 2, float(after_s - before_s) / math.sqrt(12)


def _rate(trial: Trial, values: FloatArray) -> FloatArray:
    """Slope of columns, (T, C)."""
    t_ns = np.round((trial.time_s - trial.time_s[0]) * 1e9).astype(np.int64)
    half_s = max(SMOOTH_S, 1.5 * float(np.median(np.diff(trial.time_s))))
    rate = centred_rate(t_ns, np.ascontiguousarray(values), round(half_s * 1e9))
    time_s = trial.time_s  # at the ends the slope is that of one side, which no motion has
    rate[(time_s < time_s[0] + half_s) | (time_s > time_s[-1] - half_s)] = np.nan
    return rate


def _motions(
    base: Trial, other: Trial, signal: str, predicted: Predicted | None
) -> tuple[FloatArray, FloatArray]:
    """One of the signals by the model of the run's shafts, and of the other's poses, (T, C) both."""
    if predicted is None:
        raise RecordError(
            f'clock: {signal} needs the machine\'s model: add robot = "FILE.toml" to [trial], or name '
            "columns = [...]"
        )
    model = predicted(base)
    rate = _rate(other, np.column_stack([other.body_position_m, other.body_angles_rad[:, 2]]))
    pairs = {
        HEIGHT: (_rate(base, model[:, 3:])[:, 0], rate[:, 2]),
        SPEED: (_smooth(base, np.hypot(*model[:, :2].T)), np.hypot(*rate[:, :2].T)),
        YAW_RATE: (_smooth(base, model[:, 2]), rate[:, 3]),
    }
    wanted = (HEIGHT, SPEED) if signal == MOTION else (signal,)
    ours, theirs = zip(*(pairs[name] for name in wanted), strict=True)
    return np.column_stack(ours), np.column_stack(theirs)


def _smooth(trial: Trial, rate: FloatArray) -> FloatArray:
    """Rates as the slope over a stretch would give them: what they add up to, differentiated again."""
    steps = np.diff(trial.time_s, prepend=trial.time_s[:1])
    summed = np.cumsum(np.nan_to_num(rate) * steps)
    return np.where(np.isfinite(rate), _rate(trial, summed[:, None])[:, 0], np.nan)


def _lag(base: Trial, first: FloatArray, other: Trial, then: FloatArray) -> tuple[Lag, float]:
    """The lag between two signals on grids of one period, and how much later the first begins."""
    times = (base.time_s, other.time_s)
    period_s = max(SHORTEST_PERIOD_S, *(float(np.median(np.diff(t))) for t in times))
    x, y = (
        np.column_stack([at_times(t, one, np.arange(t[0], t[-1], period_s)) for one in values.T])
        for t, values in zip(times, (first, then), strict=True)
    )
    longest_s = period_s * (len(x) + len(y))
    return best_lag(x, y, period_s, longest_s, OVERLAP), float(base.time_s[0] - other.time_s[0])


def _check(lag: Lag, start_s: float, name: str) -> None:
    """Refuse an alignment that is not sure.

    Raises:
        RecordError: The signals are not alike, or several offsets fit as well.
    """
    advice = 'begin and end recordings standing, or align by = "event" or by = "offset"'
    if not lag.correlation > ALIKE:
        raise RecordError(
            f"clock: {name} of the two files are not alike (correlation {lag.correlation:.2f}): check "
            f"columns, axes and units; {advice}"
        )
    if lag.sigmas < SURE_SIGMAS:
        one, other = start_s - lag.seconds, start_s - lag.rival_s
        raise RecordError(
            f"clock: {name} fits as well {one:+.3f} s (correlation {lag.correlation:.3f}) as {other:+.3f} "
            f"s ({lag.rival_correlation:.3f}): the motion repeats itself; {advice}"
        )
