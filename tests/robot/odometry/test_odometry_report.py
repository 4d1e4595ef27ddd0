"""What ``bigant odom`` says of a walk, in a terminal and on a page."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.values.estimate import Health
from robot.odometry.compare import OdometryComparison, compare_methods
from robot.odometry.estimates import EstimateSeries
from robot.odometry.figure import drawing
from robot.odometry.health import poor_health
from robot.odometry.metrics import Motion, TrackErrors
from robot.odometry.page import odometry_page
from robot.odometry.table import health_rows, table
from robot.odometry.track import track_log
from robot.report.run_date import date_words
from tests.robot.browser import without_scripts

GOLDEN = Path(__file__).resolve().parents[2] / "replay" / "golden" / "faults.mcap"
NAMES = ("HL", "ML", "FL", "HR", "MR", "FR")
WIDE = 116


@pytest.fixture(scope="module")
def found() -> OdometryComparison:
    """A walk, with a truth and errors that are made up: the log has none."""
    told = compare_methods(track_log(GOLDEN))
    ticks = len(told.track.t_s)
    truth = Motion("truth", told.track.pose, told.track.velocity_B, told.track.force_B)
    nothing = np.full(3, np.nan)
    errors = tuple(
        TrackErrors(w.name, nothing, 0.5, -1e-9, np.full(3, -1e-9), np.ones((6, 3)))
        for w in told.motions
    )
    ideal = np.full(ticks, 3.0)
    return replace(told, truth=truth, errors=errors, twist_nees=ideal, pose_nees=ideal)


def with_reasons(found: OdometryComparison, reasons: list[str]) -> OdometryComparison:
    estimates = list(found.track.estimates)
    fine = replace(estimates[0], health=Health.OK, reason="")
    told = [replace(fine, health=Health.DEGRADED, reason=reason) for reason in reasons]
    rest = [fine] * (len(estimates) - len(told))
    return replace(found, track=replace(found.track, estimates=EstimateSeries.of([*told, *rest])))


def test_a_reason_keeps_its_numbers_and_reasons_that_differ_in_numbers_are_one_row(
    found: OdometryComparison,
) -> None:
    one, two = (f"no encoder reading from {k} of 6 legs" for k in (1, 2))
    rows = health_rows(with_reasons(found, [two, one, one, "no forces for 0.6 s"]))
    assert rows[0][0] == "health"
    assert rows[1:] == [
        ("  degraded", f"{one} (most often; other numbers, too), 3 ticks, 5.1 to 5.4 s"),
        ("  degraded", "no forces for 0.6 s, 1 tick, 5.4 to 5.5 s"),
    ]


def test_a_tick_with_two_reasons_counts_in_each_and_a_reason_s_worst_health_is_its_own(
    found: OdometryComparison,
) -> None:
    both = with_reasons(found, ["no forces for 0.6 s; picked up", "picked up", "picked up"])
    estimates = list(both.track.estimates)
    estimates[2] = replace(estimates[2], health=Health.LOST)
    estimates[5] = replace(estimates[5], health=Health.DEGRADED, reason="picked up")
    up, forces = poor_health(replace(both.track, estimates=EstimateSeries.of(estimates)))
    assert (up.health, up.reason, up.ticks) == (Health.LOST, "picked up", 4)
    assert (forces.health, forces.ticks) == (Health.DEGRADED, 1)
    t_s = both.track.t_s
    np.testing.assert_array_equal(up.periods, [[t_s[0], t_s[3]], [t_s[5], t_s[6]]])
    assert up.times.endswith(", 2 times")
    assert up.share == pytest.approx(4 / len(estimates))


@pytest.mark.usefixtures("words_only")
def test_the_page_gives_the_reason_the_forces_the_part_and_what_words_mean(
    found: OdometryComparison,
) -> None:
    why = "no encoder reading from 1 of 6 legs"
    page = odometry_page(with_reasons(found, [why]), Path("a/walk.mcap"), "2026-02-03")
    for words in (
        why,
        "a/walk.mcap, 2026-02-03",
        "Fz, N",
        "relative pose error",
        "NEES",
        "Unknown: RPE: the walk is",
    ):
        assert words in page, words
    part = f"{len(found.track.t_s)} of {found.log_ticks} ticks"
    assert len(found.track.t_s) < found.log_ticks
    assert part in page
    assert "nan" not in without_scripts(page)


def test_a_narrow_terminal_gets_two_tables_with_the_same_numbers(found: OdometryComparison) -> None:
    wide = table(found)
    narrow = table(found, 80)
    assert table(found, WIDE) == wide
    assert max(map(len, wide)) > 80 >= max(map(len, narrow))
    more = Counter(" ".join(narrow).split()) - Counter(" ".join(wide).split())
    again = ["method", *(way.name for way in found.motions), "leg", *NAMES]
    assert more == Counter(" ".join(again).split())


def test_no_minus_before_a_zero_and_no_nan(found: OdometryComparison) -> None:
    text = "\n".join(table(found))
    assert "-0.00" not in text
    assert "nan" not in text


def test_the_picture_names_every_leg_and_says_what_is_stretched(found: OdometryComparison) -> None:
    ahead = found.track.pose + np.linspace(0, 1, len(found.track.t_s))[:, None] * [0.5, 0, 0]
    walk = Motion("truth", ahead, found.track.velocity_B, found.track.force_B)
    path, error, _, friction = drawing(replace(found, truth=walk)).axes
    legend = friction.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == list(NAMES)
    ways = {line.get_color() for line in path.lines}
    assert not ways & {line.get_color() for line in friction.lines}
    assert "stretched" in path.get_ylabel()
    assert "2 sd, as the estimator says" in error.get_legend_handles_labels()[1]


def test_the_date_of_a_run_is_that_of_its_log_and_virtual_time_has_none() -> None:
    stamps = {"start_unix_ns": "1767225600000000000"}
    assert date_words(stamps) == "2026-01-01 00:00:00 UTC"
    assert "without a date" in date_words({**stamps, "time": "virtual"})
    assert date_words({}) == "of unknown date"
