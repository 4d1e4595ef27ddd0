"""``bigant odom LOG --html FILE``: where an estimate comes from, and how far it can be trusted.

One page; docs/odometry.md shows it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.values.arrays import known_mean
from model.values.estimate import Health
from robot.console.table import formed, number_text
from robot.odometry import figure_evidence as evidence
from robot.odometry import page_words as words
from robot.odometry.compare import OdometryComparison
from robot.odometry.figure import LAST_S
from robot.odometry.health import noticed, period_words, poor_health, share_of
from robot.odometry.sources import BLOCK_S, rejected_of, sources_of
from robot.odometry.table import (
    NAIVE,
    Figures,
    error_columns,
    force_words,
    leg_columns,
    moved_words,
    stride_words,
    unknown_rows,
    walking_words,
)
from robot.report.page import PagePicture, render
from robot.report.pictures import page_picture
from robot.report.plots import STYLE

MOST_REASONS = 12
MOST_SD = 3.0
NEES_LOW, NEES_HIGH = 1.5, 6.0  # between them, error bars are about as large as errors


@dataclass(frozen=True, slots=True)
class PagePart:
    """A part of the page: a sentence, pictures, a table; what is empty is left out.

    Attributes:
        title: Its heading.
        says: What it shows, in a sentence or two.
        pictures: Its pictures.
        head: Names of the table's columns.
        rows: Its rows.
        numbers: Columns that are set to the right.
        note: Below it.
        folded: Whether it opens at a click.
    """

    title: str
    says: str = ""
    pictures: Sequence[PagePicture] = ()
    head: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    numbers: Sequence[int] = ()
    note: str = ""
    folded: bool = False


def odometry_page(comparison: OdometryComparison, log: Path, date: str) -> str:
    """Return the page of a log that was recorded on a ``date``, in words."""
    kind, verdict = verdict_of(comparison)
    judged = "judged against the truth in the log" if comparison.errors else "no truth in this log"
    with mpl.rc_context({**STYLE, "font.size": 8}):
        parts = [
            _path(comparison),
            *_errors(comparison),
            _health(comparison),
            _noticed(comparison),
            _innovations(comparison),
            _rejected(comparison),
            _forces(comparison),
            _legs(comparison),
            PagePart(
                "What the words mean", head=("word", "meaning"), rows=words.MEANINGS, folded=True
            ),
        ]
    return render(
        "odometry.html",
        title=f"{log.name}: odometry",
        note=f"{log}, {date}; {judged}; the walking part only: {walking_words(comparison)}",
        kind=kind,
        verdict=verdict,
        numbers=_numbers(comparison),
        parts=parts,
    )


def verdict_of(comparison: OdometryComparison) -> tuple[str, str]:
    """How far the estimate can be trusted: pass, warn, fail or nothing, and a sentence."""
    run = comparison.track
    fine, lost = 100 * share_of(run, Health.OK), 100 * share_of(run, Health.LOST)
    end = ""
    if comparison.errors and np.isfinite(comparison.errors[0].end_percent):
        end = f" It ends {comparison.errors[0].end_percent:.1f} % of the path off the ground truth."
    if fine < 100.0:
        why = f"most often: {poor_health(run)[0].words}.{end}"
        if lost > 0.0:
            return "fail", f"Lost for {lost:.0f} % of the time, in order for {fine:.0f} %; {why}"
        return "warn", f"In doubt for {number_text(100 - fine, 1)} % of the time; {why}"
    if not comparison.errors:
        return "", f"In good health all the time. {words.NO_TRUTH}"
    for name, values in (("velocity", comparison.twist_nees), ("pose", comparison.pose_nees)):
        if (nees := known_mean(values)) > NEES_HIGH:
            return "warn", f"{words.OVERCONFIDENT}: {name} NEES {nees:.1f}, 3 is ideal.{end}"
    if (times := _end_in_sd(comparison)) > MOST_SD:
        return "warn", f"{words.OVERCONFIDENT}: {times:.1f} times the sd of its place.{end}"
    return "pass", f"In good health all the time.{end}"


def _end_in_sd(comparison: OdometryComparison) -> float:
    """How far off the last known place is, over the distance that the estimator expects; NaN if unknown."""
    if comparison.truth is None:
        return np.nan
    run = comparison.track
    off_m = np.hypot(*(run.pose - comparison.truth.pose)[:, :2].T)
    last = np.flatnonzero(np.isfinite(off_m))[-1]
    return float(off_m[last] / np.sqrt(np.trace(run.displacement_covariance[last, :2, :2])))


def _numbers(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """The few numbers at the top, each with what it is a number of."""
    run, (ahead, aside, turned) = comparison.track, moved_words(comparison)
    numbers = [(ahead.removesuffix(" ahead"), f"ahead (+- sd); {aside}, {turned}")]
    of = ("of the path off at the end", "the same of the open loop")
    numbers += [
        (f"{one.end_percent:.1f} %", name)
        for one, name in zip(comparison.errors[: NAIVE + 1], of, strict=False)
        if np.isfinite(one.end_percent)
    ]
    numbers.append((f"{100 * share_of(run, Health.OK):.0f} %", "of the time: health ok"))
    nees = known_mean(comparison.twist_nees)
    if np.isfinite(nees):
        fit = "too large" if nees < NEES_LOW else "too small" if nees > NEES_HIGH else "about right"
        numbers.append((f"{nees:.1f}", f"NEES of the velocity, 3 is ideal: error bars {fit}"))
    return numbers


def _path(comparison: OdometryComparison) -> PagePart:
    pictures = [_picture("Path", evidence.path_figure(comparison), words.PATH)]
    if comparison.truth is not None:
        figure = evidence.error_figure(comparison)
        pictures.append(_picture("Distance from the truth", figure, words.DISTANCE))
    return PagePart("Path", pictures=pictures)


def _errors(comparison: OdometryComparison) -> list[PagePart]:
    """What needs the ground truth."""
    if comparison.truth is None:
        return [PagePart("Errors", words.IMPORT_TRUTH)]
    notes = [*stride_words(comparison), *(f"{a}: {b}" for a, b in unknown_rows(comparison))]
    names = [one.name for one in comparison.errors]
    part = replace(
        _table("Errors", "method", names, error_columns(comparison.errors)),
        says=words.ERRORS,
        note=" ".join(f"{note[:1].upper()}{note[1:]}." for note in notes),
    )
    if not np.isfinite(comparison.twist_nees).any():
        return [part]
    picture = _picture("Velocity errors", evidence.velocity_figure(comparison), words.VELOCITY)
    return [part, PagePart("Velocity errors and their bands", pictures=[picture])]


def _health(comparison: OdometryComparison) -> PagePart:
    run = comparison.track
    healths, reasons = run.estimates.healths, poor_health(run)
    rows = [
        (str(number), one.words, one.health.value, f"{100 * one.share:.1f} %", one.times)
        for number, one in enumerate(reasons[:MOST_REASONS], 1)
    ]
    more = len(reasons) - len(rows)
    figure = evidence.health_figure(healths, reasons[:MOST_REASONS], run.t_s)
    return PagePart(
        "Health over time",
        f"{words.HEALTH} {words.REASONS if rows else words.NO_REASON}",
        [_picture("Health", figure, "")],
        ("", "reason", "worst", "of the time", "from, to"),
        rows,
        (3,),
        f"{more} more reasons, each rarer." * bool(more),
    )


def _noticed(comparison: OdometryComparison) -> PagePart:
    rows = [(one.words, f"{100 * one.share:.1f} %", one.times) for one in noticed(comparison.track)]
    text = words.NOTICED if rows else words.NOTHING_NOTICED
    head = ("what the measurements say", "of the time", "from, to") if rows else ()
    return PagePart(
        "Robot file and ground", text, head=head, rows=rows, numbers=(1,) if rows else ()
    )


def _innovations(comparison: OdometryComparison) -> PagePart:
    run, title = comparison.track, "Did the sensors agree with the filter?"
    fits = sources_of(run)
    if not fits:
        return PagePart(title, words.NO_MEASUREMENT)
    picture = _picture("NIS per degree of freedom", evidence.innovation_figure(fits, run.t_s), "")
    return PagePart(title, words.NIS, [picture], note=f"Means of {BLOCK_S:g} s. {words.NIS_BAND}")


def _rejected(comparison: OdometryComparison) -> PagePart:
    run, title = comparison.track, "What was rejected, and why"
    rejected = rejected_of(run, comparison.names, comparison.config.estimator.settings)
    if not rejected:
        return PagePart(
            title, words.NOTHING_REJECTED if sources_of(run) else words.NOTHING_TO_REJECT
        )
    rows = [
        (one.name, one.leg, str(one.count), one.why, period_words(one.periods)) for one in rejected
    ]
    picture = _picture("Rejections", evidence.rejection_figure(rejected, run.t_s), "")
    says = f"{sum(one.count for one in rejected)} measurements: {words.REJECTED}"
    head = ("what", "leg", "rejected", "because it was", "from, to")
    return PagePart(title, says, [picture], head, rows, (2,))


def _forces(comparison: OdometryComparison) -> PagePart:
    title = "Foot forces"
    if not np.isfinite(comparison.reference_force_n).any():
        return PagePart(title, words.NO_FORCES)
    reference = "measured" if comparison.judged_by_sensors else "true"
    pictures = [
        _picture(f"Forces on {name}", figure, "")
        for name, figure in evidence.force_figures(comparison).items()
    ]
    says = (
        f"The predicted and the {reference} force on each foot, in the last {LAST_S:g} s at most;"
    )
    return PagePart(title, f"{says} {words.AXES}", pictures)


def _legs(comparison: OdometryComparison) -> PagePart:
    pictures = [
        _picture("Friction", evidence.leg_figure(comparison, "mu"), "Friction coefficient mu."),
        _picture(
            "Stiffness", evidence.leg_figure(comparison, "stiffness"), "Vertical stiffness K."
        ),
    ]
    title = "Friction and stiffness of each leg"
    table = _table(title, "leg", comparison.names, leg_columns(comparison))
    note = force_words(comparison)
    return replace(table, says=words.LEGS, pictures=pictures, note=f"{note}." if note else "")


def _picture(name: str, figure: Figure, says: str) -> PagePicture:
    for patch in (figure.patch, *(ax.patch for ax in figure.axes)):
        patch.set_alpha(0.0)  # the page's paper, light or dark
    return page_picture(figure, name, name.lower().replace(" ", "-"), says)


def _table(title: str, label: str, names: Sequence[str], columns: Sequence[Figures]) -> PagePart:
    heads = [f"{one.name}, {one.unit}" if one.unit else one.name for one in columns]
    texts = ([formed(float(value), one.form) for value in one.values] for one in columns)
    rows = list(zip(names, *texts, strict=True))
    return PagePart(title, head=(label, *heads), rows=rows, numbers=range(1, len(heads) + 1))
