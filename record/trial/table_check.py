"""What is odd about measured data: absent, out of range, jumping, stuck. Nothing is changed here.

Ranges and rates are what no machine of this size does: a value beyond them is a broken sensor, a wrong
unit or a wrong column, and is reported, not removed.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, trial_places

STUCK_S, STUCK_SAMPLES = 1.0, 20
STUCK_SHAFT_S, MOVED_RAD = 0.5, 0.2
ANSWERS_S = 0.3  # in which a shaft begins to follow a command that has moved
GAP_PERIODS = 2.5
RATE_TOLERANCE = 0.05
MANY = 0.1  # share of steps from which on it is no lone jump
# Machines are sampled at 2 Hz to 20 kHz; what lies between is in one of these units.
SAMPLED_S = (5e-5, 0.5)
TIME_UNITS = (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))
# Units that are taken for ours by mistake, and what one of them is.
MISTAKEN = {"rad": (("deg", np.pi / 180),), "m": (("mm", 1e-3), ("cm", 1e-2))}


@dataclass(frozen=True, slots=True)
class Plausible:
    """Believable values of a quantity.

    Attributes:
        pattern: Columns it is for, a regular expression.
        lowest: Smallest value.
        highest: Largest value.
        rate: Largest change a second; infinite where there is none.
        unit: Unit, for words.
    """

    pattern: str
    lowest: float
    highest: float
    rate: float
    unit: str


PLAUSIBLE = (
    Plausible(r"(command|shaft)_.+_rad", -2000, 2000, 20, "rad"),  # 300 turns; 20 rad/s is 190 rpm
    Plausible(r"shaft_.+_rad_s", -20, 20, np.inf, "rad/s"),
    Plausible(r"current_.+", -10, 10, np.inf, "A"),  # an MX-106 stalls at 5
    Plausible(r"voltage_.+", 4, 30, np.inf, "V"),
    Plausible(r"temperature_.+", -20, 120, 20, "C"),
    Plausible(r"pwm_.+", -1, 1, np.inf, ""),
    Plausible(r"torque_.+", -50, 50, np.inf, "N m"),
    Plausible(r"foot_.+", -2, 2, 5, "m"),
    Plausible(r"force_.+", -2000, 2000, np.inf, "N"),
    Plausible(r"body_[xyz]_m", -100, 100, 5, "m"),
    Plausible(r"body_(roll|pitch)_rad", -np.pi, np.pi, 20, "rad"),
    Plausible(r"body_yaw_rad", -1000, 1000, 20, "rad"),
)


@dataclass(frozen=True, slots=True)
class TableFinding:
    """One odd thing.

    Attributes:
        kind: absent, ignored, unreadable, order, range, jump, stuck, missing, gap or rate.
        column: Column it concerns, empty for the whole.
        count: How many samples.
        first_row: First row concerned, counted from 1 in the original table; 0 where it is none.
        detail: Words for a person, with the figures.
    """

    kind: str
    column: str
    count: int
    first_row: int
    detail: str


def check_trial(trial: Trial, rows: FloatArray) -> tuple[TableFinding, ...]:
    """Look through a trial.

    Args:
        trial: The trial.
        rows: Number of each sample's row in the original table, (T,).
    """
    findings = [*_time(trial, rows)]
    columns = trial.columns()[1:]
    for column in columns:
        limits = next((p for p in PLAUSIBLE if re.fullmatch(p.pattern, column.name)), None)
        findings += _missing(column, rows)
        if limits is not None:
            findings += _range(column, limits, rows)
            findings += _jumps(column, limits, trial.time_s, rows)
    findings += _stuck(trial, rows)
    return tuple(findings)


def _finding(kind: str, column: str, odd: BoolArray, rows: FloatArray, detail: str) -> TableFinding:
    return TableFinding(kind, column, int(odd.sum()), int(rows[np.flatnonzero(odd)[0]]), detail)


def _time(trial: Trial, rows: FloatArray) -> Iterator[TableFinding]:
    if len(trial.time_s) < 3:
        return
    steps = np.diff(trial.time_s)
    period = float(np.median(steps))
    gaps = np.concatenate([[False], steps > GAP_PERIODS * period])
    if gaps.any():
        longest = float(steps.max())
        yield _finding("gap", "time_s", gaps, rows,
                     f"steps longer than {GAP_PERIODS:g} periods of {period:.4g} s; the longest "
                     f"{longest:.4g} s")  # fmt: skip
    if not SAMPLED_S[0] <= period <= SAMPLED_S[1]:
        fit = [unit for unit, size in TIME_UNITS if SAMPLED_S[0] <= period * size <= SAMPLED_S[1]]
        hint = f'; if theirs are in {fit[0]}, map them with unit = "{fit[0]}"' if fit else ""
        words = f"samples lie {period:.4g} s apart{hint}"
        yield TableFinding("unit", "time_s", len(trial.time_s), 0, words)
    wanted = trial.header.sample_rate_hz
    if np.isfinite(wanted) and abs(period * wanted - 1) > RATE_TOLERANCE:
        yield TableFinding("rate", "time_s", len(trial.time_s), 0,
                      f"median rate is {1 / period:.5g} Hz, the header says {wanted:g} Hz")  # fmt: skip


def _missing(column: TableColumn, rows: FloatArray) -> Iterator[TableFinding]:
    odd = np.isnan(column.values)
    if odd.any():
        yield _finding("missing", column.name, odd, rows, f"{odd.mean():.2%} of samples are NaN")


def _range(column: TableColumn, limits: Plausible, rows: FloatArray) -> Iterator[TableFinding]:
    odd = (column.values < limits.lowest) | (column.values > limits.highest)
    if odd.any():
        worst = column.values[odd][np.argmax(np.abs(column.values[odd]))]
        yield _finding("range", column.name, odd, rows,
                     f"beyond {limits.lowest:.4g} to {limits.highest:.4g} {limits.unit}; the worst "
                     f"{worst:.4g}{_unit_hint(abs(worst), limits.highest, limits.unit)}")  # fmt: skip


def _unit_hint(size: float, limit: float, unit: str) -> str:
    """Words on the unit in which a value would be believable; empty for none."""
    for name, factor in MISTAKEN.get(unit, ()):
        if size * factor <= limit:
            return f'; if theirs are in {name}, map them with unit = "{name}"'
    return ""


def _jumps(
    column: TableColumn, limits: Plausible, time_s: FloatArray, rows: FloatArray
) -> Iterator[TableFinding]:
    known = np.flatnonzero(np.isfinite(column.values))
    if len(known) < 2 or not np.isfinite(limits.rate):
        return
    steps = np.diff(column.values[known])
    fast = np.abs(steps) > limits.rate * np.diff(time_s[known])
    if not fast.any():
        return
    many = fast.mean() > MANY
    worst = float(steps[fast][np.argmax(np.abs(steps[fast]))])
    wrapped = column.name.endswith("_rad") and abs(abs(worst) - 2 * np.pi) < 0.5
    if column.name.startswith("command_") and not many and not wrapped:
        return  # a command may step; many steps are another unit, and a turn is no step
    odd = np.zeros(len(time_s), dtype=bool)
    odd[known[1:][fast]] = True
    speed = float(np.max(np.abs(steps) / np.diff(time_s[known])))
    other = _unit_hint(speed, limits.rate, limits.unit) if many else ""
    hint = "; a turn: it is not unwrapped" if wrapped else other
    yield _finding("jump", column.name, odd, rows,
                 f"faster than {limits.rate:g} {limits.unit}/s; the largest step {worst:.4g}"
                 f"{hint}")  # fmt: skip


def _stuck(trial: Trial, rows: FloatArray) -> Iterator[TableFinding]:
    for place in trial_places(trial.header.names):
        values = trial.values(place)
        if place.field == "shaft_rad":
            odd = _stuck_shaft(trial.time_s, values, trial.command_rad[place.where])
            words = f"the same for {STUCK_SHAFT_S:g} s and more while its command moved"
        elif place.field in {"foot_m", "force_n", "body_position_m", "body_angles_rad"}:
            odd = _stuck_sensor(trial.time_s, values)
            words = f"the same to the last digit for {STUCK_S:g} s and more"
            if odd.all() and len(odd):
                words = f"always {values[0]:g}; if it was not measured, leave the column out"
        else:
            continue
        if odd.any():
            yield _finding("stuck", place.column, odd, rows, words)


def _runs(time_s: FloatArray, values: FloatArray, least_s: float) -> Iterator[slice]:
    """Yield each run of one and the same value that lasts so long."""
    edges = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1], [True]]))
    for first, behind in pairwise(edges.tolist()) if len(values) else ():
        if behind - first > 1 and time_s[behind - 1] - time_s[first] >= least_s:
            yield slice(first, behind)


def _stuck_sensor(time_s: FloatArray, values: FloatArray) -> BoolArray:
    odd = np.zeros(len(values), dtype=bool)
    for run in _runs(time_s, values, STUCK_S):
        count = run.stop - run.start
        # exactly 0 for a while is what an unloaded foot gives in data without noise
        odd[run] = count >= STUCK_SAMPLES and (count == len(values) or values[run.start] != 0)
    return odd


def _stuck_shaft(time_s: FloatArray, values: FloatArray, command: FloatArray) -> BoolArray:
    odd = np.zeros(len(values), dtype=bool)
    for run in _runs(time_s, values, STUCK_SHAFT_S):
        known = run.start + np.flatnonzero(np.isfinite(command[run]))
        if len(known) < 2:
            continue
        # a shaft that holds rests, too, until its command has stepped
        away = known[np.abs(command[known] - command[known[0]]) > MOVED_RAD]
        odd[run] = len(away) > 0 and time_s[run.stop - 1] - time_s[away[0]] > ANSWERS_S
    return odd
