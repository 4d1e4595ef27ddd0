"""The page of ``bigant odom --html``: each part, the right reasons, and words where there is no number."""

import html
import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Ellipse
from scipy.stats import chi2

from benchmarks.odometry.bars import without_encoder
from model.estimator.sources import GYRO, TILT
from model.values.estimate import Health
from model.values.readings import PoseRecord
from record.log.reader import StampedTick, read_stamped_ticks
from record.log.recording import Recording
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import json_text
from robot.odometry.compare import OdometryComparison, compare_methods, stride_of
from robot.odometry.figure import drawing
from robot.odometry.figure_evidence import path_figure
from robot.odometry.health import poor_health
from robot.odometry.page import odometry_page, verdict_of
from robot.odometry.sources import SourceFit, rejected_of, sources_of
from robot.odometry.table import as_json, table
from robot.odometry.track import TrackedLog, track, track_log
from tests.robot.browser import without_scripts
from tests.robot.odometry.poorer_logs import (
    MIDDLE,
    gaps,
    half_headings,
    late,
    no_forces,
    no_phase,
    no_truth,
    one_pose,
    places_only,
    standing_truth,
)

CONFIG = load_robot()
TITLES = (
    "Path", "Errors", "Velocity errors and their bands", "Health over time",
    "Robot file and ground",
    "Did the sensors agree with the filter?", "What was rejected, and why", "Foot forces",
    "Friction and stiffness of each leg", "What the words mean",
)  # fmt: skip
DEAD, KICKED = (2.0, 3.0), (3.5, 3.7)  # seconds of walking


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five seconds of the slipping gait, as a file."""
    path = tmp_path_factory.mktemp("page") / "walk.mcap"
    plain = path.with_name("plain.toml")  # the loop's own estimator is not looked at
    plain.write_text(f"{CONFIG.text}\n[estimator]\nenabled = false\n", encoding="utf-8")
    words = "drive --gait metachronal --cycles 0.5 --seed 5 --virtual-time --robot"
    assert cli.run([*words.split(), str(plain), "--log", str(path)]) == ExitCode.OK
    return path


@pytest.fixture(scope="module")
def tracked(log: Path) -> TrackedLog:
    return track_log(log)


@pytest.fixture(scope="module")
def found(tracked: TrackedLog) -> OdometryComparison:
    return compare_methods(tracked, stride_m=stride_of(tracked.log))


def hurt(item: StampedTick, walking_s: float) -> StampedTick:
    """A tick whose ML encoder is silent for a second, and whose HR sensor shows 60 N for a moment."""
    tick = item.tick
    if DEAD[0] <= walking_s < DEAD[1]:
        tick = without_encoder(item, 1).tick
    if KICKED[0] <= walking_s < KICKED[1]:
        force = tick.forces.force_n.copy()
        force[3] += 60.0
        tick = replace(tick, forces=replace(tick.forces, force_n=force))
    return replace(item, tick=tick)


@pytest.fixture(scope="module")
def troubled(log: Path, tracked: TrackedLog, found: OdometryComparison) -> OdometryComparison:
    """The walk with a dead encoder for a while, and a sensor that is kicked."""
    items = list(read_stamped_ticks(log))
    begun_ns = items[0].unix_ns + round(found.track.t_s[0] * 1e9)
    ill = track([hurt(one, (one.unix_ns - begun_ns) * 1e-9) for one in items], CONFIG)
    return compare_methods(replace(tracked, track=ill), stride_m=0.07)


def page_of(comparison: OdometryComparison) -> str:
    return without_scripts(odometry_page(comparison, Path("walk.mcap"), "2026-02-03"))


def headings(page: str) -> list[str]:
    return [html.unescape(one) for one in re.findall(r"<(?:h2|summary)>(.*?)</", page)]


def text_of(page: str) -> str:
    """What a person reads on a page, on one line."""
    body = re.sub(r"<style>.*?</style>|<svg.*?</svg>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", body)).split())


@pytest.mark.soak
def test_the_page_has_every_part_with_its_picture_and_no_nan(found: OdometryComparison) -> None:
    page = page_of(found)
    assert headings(page) == list(TITLES)
    pictures = re.findall(r"aria-label='([^']+)'", page)
    assert pictures[:3] == ["Path", "Distance from the truth", "Velocity errors"]
    assert {"Health", "NIS per degree of freedom", "Friction", "Stiffness"} <= set(pictures)
    assert [one for one in pictures if one.startswith("Forces on")] == [
        f"Forces on {name}" for name in found.names
    ]
    assert "nan" not in page
    text = text_of(page)
    assert text.count("calibrated on this log's own ground truth") == 1
    assert "distance a stride" in text
    assert f"{found.errors[0].end_percent:.1f} % of the path off at the end" in text


@pytest.mark.usefixtures("words_only")
def test_reasons_and_rejections_are_on_the_page_with_their_times(
    troubled: OdometryComparison,
) -> None:
    run = troubled.track
    (dead,) = [one for one in poor_health(run) if one.reason.startswith("no encoder")]
    walking = dead.periods - run.t_s[0]
    np.testing.assert_allclose(walking, [DEAD], atol=0.03)
    assert dead.share == pytest.approx(1.0 / (run.t_s[-1] - run.t_s[0]), rel=0.05)
    rejected = rejected_of(run, troubled.names, troubled.config.estimator.settings)
    loads = [one for one in rejected if one.name == "load"]
    assert loads
    times = np.concatenate([one.periods for one in loads]) - run.t_s[0]
    assert KICKED[0] <= times.min() < times.max() < KICKED[1] + 0.1
    assert sum(one.count for one in rejected) == run.rejected
    text = text_of(page_of(troubled))
    assert f"{dead.reason} {dead.health.value} {100 * dead.share:.1f} % {dead.times}" in text
    for one in loads:
        assert f"load {one.leg} {one.count} over 3.3 sd from what was expected" in text
    kind, verdict = verdict_of(troubled)
    assert kind == ("fail" if Health.LOST in run.estimates.healths else "warn")
    assert "% of the time" in verdict


def posed(item: StampedTick, number: int, astray: int) -> StampedTick:
    """A tick that comes with its true pose, if it is a tenth; that of one tick is 5 m off."""
    tick, truth = item.tick, item.tick.inputs.truth
    if number % 10 or truth is None:
        return item
    off = np.array([5.0, 0.0, 0.0]) * (number == astray)
    pose = PoseRecord(tick.t_ns, truth.position_W + off, truth.quaternion_xyzw, np.nan, np.nan)
    return replace(item, tick=replace(tick, inputs=replace(tick.inputs, poses=(pose,))))


@pytest.mark.usefixtures("words_only")
def test_a_pose_that_is_metres_away_is_among_the_rejected(
    log: Path, tracked: TrackedLog, found: OdometryComparison
) -> None:
    items = list(read_stamped_ticks(log))
    run = track([posed(one, number, MIDDLE) for number, one in enumerate(items)], CONFIG)
    comparison = compare_methods(replace(tracked, track=run))
    rejected = rejected_of(comparison.track, found.names, CONFIG.estimator.settings)
    (pose,) = [one for one in rejected if one.name == "absolute pose"]
    assert (pose.count, pose.leg) == (1, "")
    assert pose.periods[0, 0] == run.t_s[MIDDLE]
    sd = np.sqrt(np.diagonal(comparison.track.displacement_covariance, axis1=1, axis2=2))
    own = np.sqrt(np.diagonal(run.estimates[-1].pose_covariance))
    assert (sd[0] < 1.1e-4).all()
    assert (own < sd[-1]).all()
    assert (sd[-1] < 3 * own).all(), "it does not grow: both ends are known to a few millimetres"
    assert np.nanmean(comparison.pose_nees) < 6
    assert "absolute pose 1 over 4.0 sd from what was expected, or over 1 m" in text_of(
        page_of(comparison)
    )


def test_rejections_of_gyro_and_tilt_are_named(found: OdometryComparison) -> None:
    rejections = np.zeros_like(found.track.rejections)
    rejections[[10, 11, 50], GYRO, 0] = rejections[20, TILT, 1] = True
    run = replace(found.track, rejections=rejections)
    gyro, pitch = rejected_of(run, found.names, CONFIG.estimator.settings)
    assert (gyro.place, gyro.count, len(gyro.periods)) == ("gyro", 3, 2)
    assert (pitch.place, pitch.count) == ("tilt pitch", 1)


@pytest.mark.usefixtures("words_only")  # drawing() draws
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (places_only, "Unknown: RPE, yaw, velocities, NEES: the ground truth has places without a heading"),
        pytest.param(gaps, "calibrated on this log's own ground truth", marks=pytest.mark.soak),
        (late, "Unknown: RPE: the walk is"),
        pytest.param(half_headings, "Velocity errors and their bands", marks=pytest.mark.soak),
        (one_pose, "This log has no ground truth, so no errors can be shown"),
        (no_truth, "no truth in this log"),
        (no_forces, "No foot forces were measured"),
        (standing_truth, "Unknown: end, yaw: the ground truth does not move"),
        (no_phase, "rigid stance"),
    ],
)  # fmt: skip
def test_what_has_no_number_has_words(
    change: Callable[[Recording], Recording], words: str, tracked: TrackedLog
) -> None:
    """In the terminal, as JSON, on the page and in the picture: nothing is nan, and nothing warns."""
    some = replace(tracked, log=change(tracked.log))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = compare_methods(some, stride_m=stride_of(some.log))
        for one in (found, found.of_estimator()):
            for width in (None, 80):
                lines = "\n".join(table(one, width))
                assert "nan" not in lines
        drawing(found)
        page = page_of(found)
    assert "nan" not in page
    assert words in text_of(page)
    assert "NaN" not in json_text(as_json(found))
    json.loads(json_text(as_json(found)))


@pytest.mark.usefixtures("words_only")
def test_without_a_phase_there_is_no_distance_a_stride_and_no_word_of_it(
    tracked: TrackedLog,
) -> None:
    log = no_phase(tracked.log)
    assert np.isnan(stride_of(log))
    found = compare_methods(replace(tracked, log=log), stride_m=stride_of(log))
    assert "distance a stride" not in "\n".join(table(found))
    assert "calibrated" not in text_of(page_of(found))


def test_forces_are_judged_by_the_sensors_where_the_true_ones_are_not_known(
    tracked: TrackedLog, found: OdometryComparison
) -> None:
    log = replace(tracked.log, truth_force_n=np.full_like(tracked.log.truth_force_n, np.nan))
    real = compare_methods(replace(tracked, log=log))
    assert real.judged_by_sensors
    assert not found.judged_by_sensors
    off = real.track.force_B - real.measured_force_n
    known = np.isfinite(off) & np.isfinite(real.motions[1].force_B)
    wanted = np.sqrt(np.mean(off[known.all(axis=(1, 2))] ** 2, axis=0))
    np.testing.assert_allclose(real.leg_force_rmse(0), wanted, rtol=1e-9)
    assert "RMSE against the measured forces" in "\n".join(table(real))
    assert "RMSE against the true forces" in "\n".join(table(found))
    heads = [line for line in table(found) if line.startswith("leg")]
    assert all(f"open loop F{axis}" in heads[0] for axis in "xyz")


def test_innovations_of_white_noise_have_a_mean_of_one_and_stay_in_their_band() -> None:
    draw = np.random.default_rng(0)
    t_s, numbers = np.arange(0, 60, 0.01), np.full(6000, 6)
    fit = SourceFit("load", draw.chisquare(6, 6000), numbers)
    assert fit.mean == pytest.approx(1, abs=0.02)
    middle_s, ratio, (low, high) = fit.blocks(t_s)
    assert len(ratio) == 60
    np.testing.assert_allclose(middle_s, np.arange(60) + 0.495)
    assert low[0] == pytest.approx(chi2.ppf(0.025, 600) / 600)
    assert high[0] == pytest.approx(chi2.ppf(0.975, 600) / 600)
    assert fit.in_band(t_s) > 0.85
    assert replace(fit, squared=4 * fit.squared).in_band(t_s) == 0


def test_sources_add_up_what_each_foot_s_innovation_says(found: OdometryComparison) -> None:
    fits = {one.name: one for one in sources_of(found.track)}
    normal = found.track.column("innovation")
    load = normal[..., 2][np.isfinite(normal[..., 2])]
    assert fits["load"].numbers.sum() == len(load)
    # what one foot carries too much, others carry too little: they are not independent
    assert fits["load"].mean == pytest.approx(np.mean(load**2), rel=0.3)
    gauge = found.track.column("nis_dof").sum() - sum(f.numbers.sum() for f in fits.values())
    assert 0 < gauge < len(found.track.t_s)


def test_ellipses_are_those_of_the_growth_of_the_covariance(found: OdometryComparison) -> None:
    (ax,) = path_figure(found).axes
    *_, last = ax.patches
    assert isinstance(last, Ellipse)
    variance = np.linalg.eigvalsh(found.track.displacement_covariance[-1, :2, :2])
    half = 1e3 * np.sqrt(chi2.ppf(0.95, 2) * variance)
    drawn = np.sort([last.get_width(), last.get_height()]) / 2
    np.testing.assert_allclose(drawn, half)
    np.testing.assert_allclose(last.get_center(), 1e3 * found.track.pose[-1, :2])


def test_an_estimate_that_is_farther_off_than_it_believes_is_not_called_good(
    found: OdometryComparison,
) -> None:
    assert verdict_of(found)[0] == "pass"
    for name in ("twist_nees", "pose_nees"):
        sure = replace(found, **{name: np.full(len(found.track.t_s), 280.0)})  # type: ignore[arg-type]
        kind, words = verdict_of(sure)
        assert kind == "warn"
        assert "NEES 280.0, 3 is ideal" in words
    assert found.truth is not None
    places = found.truth.pose.copy()
    places[:, 0] += np.linspace(0, 0.5, len(places))
    places[:, 2] = np.nan
    unknown = np.full(len(places), np.nan)
    truth = found.truth._replace(pose=places)
    far = replace(found, truth=truth, twist_nees=unknown, pose_nees=unknown)
    kind, words = verdict_of(far)
    assert (kind, "times the sd of its place" in words) == ("warn", True)


@pytest.mark.soak
def test_the_command_writes_the_same_page_by_either_option_and_keeps_an_earlier_one(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.html"
    out.write_text("an earlier page", encoding="utf-8")
    assert cli.run(["odom", str(log), "--compare", "--out", str(out)]) == ExitCode.OK
    by_out = out.read_text(encoding="utf-8")
    assert (tmp_path / "a.1.html").read_text(encoding="utf-8") == "an earlier page"
    capsys.readouterr()
    words = ["odom", str(log), "--compare", "--html", str(out), "--out", str(tmp_path / "a.tum")]
    assert cli.run(words) == ExitCode.OK
    assert f"written: {out}" in capsys.readouterr().out
    assert (tmp_path / "a.tum").exists()
    assert out.read_text(encoding="utf-8") == by_out
    assert not (tmp_path / "a.2.html").exists(), "the same page is no earlier one"


@pytest.mark.usefixtures("words_only")
def test_without_compare_the_simpler_methods_are_left_out(found: OdometryComparison) -> None:
    with_them, alone = (
        text_of(page_of(one)).split("What the words mean")[0]
        for one in (found, found.of_estimator())
    )
    for words in ("rigid stance", "distance a stride", "open loop"):
        assert words in with_them.lower()
        assert words not in alone.lower()


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--html", "a.txt"], "--html: must end in .html"),
        (["--html", "nowhere/a.html"], "there is no folder nowhere"),
        (["--live", "--html", "a.html"], "--html: needs a whole log"),
    ],
)
def test_wrong_input_is_refused_in_a_line_before_any_work(
    words: list[str], reason: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["odom", str(log), *words]) != ExitCode.OK
    said = capsys.readouterr()
    assert reason in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""


def test_odom_tune_has_no_page(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["odom", "tune", str(log), "--html", "a.html"]) == ExitCode.USAGE
    assert "--html: is not for odom tune" in capsys.readouterr().err
