"""When an estimator was not well, and why: its reasons with their times and shares."""

import re
from collections import Counter, defaultdict
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import BETWEEN, Health
from robot.odometry.track import Track

LOST_SHARE = 0.5  # of the ticks; an estimate that is lost for more of them is none
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")


@dataclass(frozen=True, slots=True, eq=False)
class PoorHealth:
    """A reason for which an estimate was not to be relied on.

    Attributes:
        health: Lost if the estimate was lost in any of these ticks, else degraded.
        reason: In words; of those that differ in their numbers only, the most frequent.
        varied: Whether there were others with other numbers.
        ticks: In how many ticks.
        share: Of all ticks.
        periods: Begin and end of each time without a break, (P, 2) [s].
    """

    health: Health
    reason: str
    varied: bool
    ticks: int
    share: float
    periods: FloatArray

    @property
    def words(self) -> str:
        """The reason."""
        return self.reason + " (most often; other numbers, too)" * self.varied

    @property
    def times(self) -> str:
        """From when to when, in words."""
        return period_words(self.periods)


def poor_health(track: Track) -> list[PoorHealth]:
    """Reasons for poor health, the longest first; a tick with several reasons counts in each of them.

    Reasons that differ in their numbers only are one.
    """
    words: defaultdict[str, Counter[str]] = defaultdict(Counter)
    rows: defaultdict[str, list[int]] = defaultdict(list)
    lost: set[str] = set()
    verdicts = zip(track.estimates.healths, track.estimates.reasons, strict=True)
    for row, (health, text) in enumerate(verdicts):
        if health is Health.OK:
            continue
        for reason in text.split(BETWEEN):
            kind = NUMBER.sub("#", reason)
            words[kind][reason] += 1
            if health is Health.LOST:
                lost.add(kind)
            if rows[kind][-1:] != [row]:
                rows[kind].append(row)
    return [
        PoorHealth(
            health=Health.LOST if kind in lost else Health.DEGRADED,
            reason=words[kind].most_common(1)[0][0],
            varied=len(words[kind]) > 1,
            ticks=len(among),
            share=len(among) / len(track.estimates),
            periods=periods(track.t_s, among),
        )
        for kind, among in sorted(rows.items(), key=lambda one: -len(one[1]))
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Noticed:
    """What measurements said of the robot file or the ground, though the estimate covers it.

    Attributes:
        words: As it was said last.
        share: Of all ticks.
        periods: Begin and end of each time without a break, (P, 2) [s].
    """

    words: str
    share: float
    periods: FloatArray

    @property
    def times(self) -> str:
        """From when to when, in words."""
        return period_words(self.periods)


def noticed(track: Track) -> list[Noticed]:
    """Return what was noticed, the longest first; remarks that differ in their numbers only are one."""
    words: dict[str, str] = {}
    rows: defaultdict[str, list[int]] = defaultdict(list)
    for row, text in enumerate(track.estimates.remarks):
        for remark in filter(None, text.split(BETWEEN)):
            kind = NUMBER.sub("#", remark)
            words[kind] = remark
            rows[kind].append(row)
    return [
        Noticed(words[kind], len(among) / len(track.estimates), periods(track.t_s, among))
        for kind, among in sorted(rows.items(), key=lambda one: -len(one[1]))
    ]


def share_of(track: Track, health: Health) -> float:
    """Share of the ticks of a health."""
    return float(np.mean([one is health for one in track.estimates.healths]))


def periods(t_s: FloatArray, rows: list[int]) -> FloatArray:
    """Begin and end of each run of ticks, (P, 2) [s]; a tick lasts until the next one.

    Args:
        t_s: Times of all ticks, (T,).
        rows: Some of them, ascending.
    """
    if not rows:
        return np.empty((0, 2))
    among = np.array(rows)
    breaks = np.flatnonzero(np.diff(among) > 1)
    first, last = among[[0, *(breaks + 1)]], among[[*breaks, len(among) - 1]]
    return np.column_stack([t_s[first], t_s[np.minimum(last + 1, len(t_s) - 1)]])


def period_words(times_s: FloatArray) -> str:
    """From when to when, and in how many pieces, of periods (P, 2) [s], P >= 1."""
    begin, end = (f"{value:.1f}" for value in (times_s[0, 0], times_s[-1, 1]))
    span = f"{begin} s" if begin == end else f"{begin} to {end} s"
    return span + (f", {len(times_s)} times" if len(times_s) > 1 else "")
