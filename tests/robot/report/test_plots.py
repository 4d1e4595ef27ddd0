"""Pictures of a run: everything in them has a name, and a robot at rest is a line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

from model.values.faults import Fault, FaultKind, StopReason
from model.values.tick import Mode
from record.log.blocks.read import read_log
from record.log.recording import Recording, join_recordings
from robot.report.plots import LEAST_M, LEAST_MM_S, LEAST_N, draw_log

GOLDEN = Path(__file__).resolve().parents[2] / "replay" / "golden" / "tripod.mcap"


@pytest.fixture(scope="module")
def walk() -> Recording:
    log = read_log(GOLDEN)
    nothing = np.zeros_like(log.t_s)
    return replace(
        log,
        truth_position_W=np.column_stack([log.dead_reckoning_pose[:, :2], nothing]),
        truth_quaternion_xyzw=np.column_stack([nothing, nothing, nothing, nothing + 1]),
        truth_velocity_B=log.predicted_velocity_B * 0.9,
    )


def axes_of(log: Recording, title: str) -> list[Axes]:
    return draw_log(log)[title].axes


def named(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_every_curve_span_and_mark_of_the_velocity_is_named(walk: Recording) -> None:
    fault = Fault(FaultKind.SERVO_HOT, "MR", "75 degC")
    reason = walk.stop_reason.copy()
    reason[-5:] = StopReason.SERVO_FAULT.value
    log = replace(walk, faults=((4, fault), (4, fault), (9, fault)), stop_reason=reason)
    top = axes_of(log, "Body velocity")[0]
    assert named(top) == ["true", "predicted", "estimator", "walking", "fault", "stop begins"]
    lines = {line.get_label(): line for line in top.lines}
    assert list(np.asarray(lines["fault"].get_xdata())) == [walk.t_s[4], walk.t_s[9]]
    assert np.asarray(lines["stop begins"].get_xdata())[0] == walk.t_s[-5]
    assert {"fault", "stop begins"} & set(named(axes_of(walk, "Body velocity")[0])) == set()


def test_the_difference_has_units(walk: Recording) -> None:
    difference = axes_of(walk, "Body velocity")[3]
    assert named(difference) == ["vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]"]
    assert difference.get_ylabel() == "predicted\nminus true"


def test_what_is_predicted_beside_the_walk_is_in_the_frame(walk: Recording) -> None:
    aside = np.flatnonzero(walk.mode != Mode.WALK.value)
    predicted = np.zeros_like(walk.predicted_velocity_B)
    predicted[aside, 2] = 0.05
    ax = axes_of(replace(walk, predicted_velocity_B=predicted), "Body velocity")[2]
    assert ax.get_ylim()[1] > 50.0


def test_a_wild_sample_does_not_flatten_the_rest(walk: Recording) -> None:
    long = join_recordings([walk] * 5, "")  # one of 90 samples is no rare one
    predicted = long.predicted_velocity_B.copy()
    predicted[7, 0] = 1e3
    ax = axes_of(replace(long, predicted_velocity_B=predicted), "Body velocity")[0]
    assert ax.get_ylim()[1] < 1e3


def test_a_robot_at_rest_is_a_line_and_not_rounding_errors(walk: Recording) -> None:
    tiny = 1e-17 * np.random.default_rng(0).normal(size=walk.truth_velocity_B.shape)
    still = replace(
        walk, truth_velocity_B=tiny, predicted_velocity_B=tiny, estimate_velocity_B=tiny,
        truth_position_W=tiny, dead_reckoning_pose=tiny, estimate_pose=tiny,
        force_n=np.zeros_like(walk.force_n), predicted_force_n=np.zeros_like(walk.force_n),
    )  # fmt: skip
    figures = draw_log(still)
    for ax in figures["Body velocity"].axes:
        assert np.ptp(ax.get_ylim()) >= LEAST_MM_S
    for ax in figures["Foot forces"].axes:
        assert np.ptp(ax.get_ylim()) >= LEAST_N
    (path,) = figures["Trajectory"].axes
    assert min(np.ptp(path.get_xlim()), np.ptp(path.get_ylim())) >= LEAST_M


def test_without_forces_the_legend_names_no_measured_ones(walk: Recording) -> None:
    blind = replace(walk, force_n=np.full_like(walk.force_n, np.nan))
    for log, words in ((walk, ["measured", "predicted"]), (blind, ["predicted"])):
        (legend,) = draw_log(log)["Foot forces"].legends
        assert [text.get_text() for text in legend.get_texts()] == words
    assert legend.get_title().get_text() == "no foot forces were measured"


def test_headings_are_named_and_do_not_look_like_the_path(walk: Recording) -> None:
    (ax,) = axes_of(walk, "Trajectory")
    assert named(ax) == ["true", "dead reckoning", "estimator", "heading of the body"]
    colours = [line.get_color() for line in ax.lines]
    assert len(set(colours)) == len(colours) == 4
