"""From figures and logs to what scripts draw: nothing is lost on the way, and what cannot be is refused."""

import base64
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from gap.diagnosis.comparison.how_far import sets_of
from record.log.blocks.read import read_log
from record.log.recording import Recording
from robot.report.moving import moving_json
from robot.report.packed import packed_floats, packed_whole
from robot.report.page import Section, report_page, with_shared_library
from robot.report.pictures import page_picture
from robot.report.replay import MOST_FRAMES, kept_frames, replay_of
from robot.report.thinning import kept_rows

GOLDEN = Path(__file__).resolve().parents[2] / "replay" / "golden" / "tripod.mcap"


def test_a_peak_between_two_points_is_kept_and_a_gap_stays_one() -> None:
    x = np.arange(100_000.0)
    y = np.sin(x / 5000)
    y[54_321], y[70_000:70_010] = 9.0, np.nan
    rows = kept_rows(x, y, 600)
    assert len(rows) <= 600
    assert {0, 54_321, 70_000, 99_999} <= set(rows.tolist())
    assert (np.diff(rows) > 0).all()
    assert np.nanmax(np.abs(np.interp(x, x[rows], np.nan_to_num(y[rows])) - np.nan_to_num(y))) > 0


def test_a_path_is_thinned_by_equal_steps_and_a_short_curve_not_at_all() -> None:
    turn = np.linspace(0, 20, 5000)
    rows = kept_rows(np.cos(turn), np.sin(turn), 100)
    assert len(rows) == 100
    assert (rows[0], rows[-1]) == (0, 4999)
    np.testing.assert_array_equal(kept_rows(turn[:50], turn[:50], 100), np.arange(50))


def test_numbers_come_back_out_of_a_page_with_what_is_unknown() -> None:
    values = np.array([[0.0, -1.25], [np.nan, 3.5]])
    floats = np.frombuffer(base64.b64decode(packed_floats(values)), "<f4")
    np.testing.assert_allclose(floats, [0.0, -1.25, 1e30, 3.5])
    packed = packed_whole(values)
    whole = np.frombuffer(base64.b64decode(str(packed["data"])), "<i2")
    assert whole[2] == -32768
    np.testing.assert_allclose(
        whole[[0, 1, 3]] * float(str(packed["scale"])), [0, -1.25, 3.5], atol=1e-4
    )


def test_a_plot_has_the_curves_names_limits_and_labels_of_its_figure() -> None:
    figure = Figure()
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot([0, 1, 2], [3.0, np.nan, 5.0], color="#000000", label="a </script> curve")
    top.axhline(4.0, color="#ff0000")
    top.fill_between([0, 1], [3, 3], [4, 4], color="#808080", alpha=0.5, label="band")
    top.legend()
    bottom.plot([0, 1, 2], [1, 2, 1], color="#0000ff")
    bottom.set(xlabel="time [s]", yscale="log", ylabel="speed [m/s]")
    text = moving_json(figure)
    assert "</script>" not in text
    plots = json.loads(text)
    assert [one["time"] for one in plots["panels"]] == [True, True]
    assert [one["name"] for one in plots["legend"]] == ["a </script> curve", "band"]
    assert plots["panels"][1]["labels"] == ["time [s]", "speed [m/s]"]
    assert '"LogScale"' in json.dumps(plots["panels"][1])
    assert moving_json(figure) == text, "the same on every run"


def test_what_has_no_counterpart_in_a_plot_is_refused() -> None:
    figure = Figure()
    figure.subplots().scatter([0, 1], [1, 0])
    with pytest.raises(TypeError, match="PathCollection has no counterpart"):
        moving_json(figure)


def test_many_pages_of_a_folder_can_share_one_library() -> None:
    figure = Figure()
    figure.subplots().plot([0, 1])
    page = report_page("t", "n", [Section("", picture=page_picture(figure, "One", "0"))])
    shared = with_shared_library(page, "plots.js")
    assert len(page) > 1_000_000 > 100_000 > len(shared)
    assert "<script src='plots.js'></script>" in shared
    assert "bigant.plots" in shared
    plain = report_page("t", "n", [Section("", [("a", "b")])])
    assert with_shared_library(plain, "plots.js") == plain
    assert "<script" not in plain


@pytest.fixture(scope="module")
def walk() -> Recording:
    return read_log(GOLDEN)


def test_of_an_hour_few_frames_are_kept_and_of_a_walk_twenty_five_a_second() -> None:
    hour = kept_frames(np.linspace(0.0, 3599.99, 360_000))
    assert len(hour) == MOST_FRAMES
    assert (hour[0], hour[-1]) == (0, 359_999)
    np.testing.assert_array_equal(kept_frames(np.linspace(0.0, 4.0, 401)), np.arange(0, 401, 4))


def test_a_replay_without_ground_truth_stands_on_its_feet(walk: Recording) -> None:
    """The golden walk has no ground truth: place from dead reckoning, height from the feet that stand."""
    replay = replay_of(walk)
    assert replay is not None
    arrays = json.loads(replay.moving)
    place = np.frombuffer(base64.b64decode(arrays["place"]), "<f4").reshape(-1, 3)
    assert np.isfinite(place).all()
    assert (place[:, 2] > 0.05).all()
    assert "<polyline" in replay.svg


def test_there_is_no_replay_where_the_robot_or_all_angles_are_unknown(walk: Recording) -> None:
    assert replay_of(replace(walk, config_text="")) is None
    assert replay_of(replace(walk, config_text="kind = 1")) is None
    assert replay_of(replace(walk, angle_rad=np.full_like(walk.angle_rad, np.nan))) is None


@pytest.mark.parametrize(("causes", "sets"), [(0, 1), (1, 2), (2, 4), (3, 8), (4, 16), (5, 12)])
def test_none_all_each_and_all_but_each_cause_are_predicted(causes: int, sets: int) -> None:
    found = sets_of(causes)
    assert len(found) == len(set(found)) == sets
    assert {(), tuple(range(causes)), *((one,) for one in range(causes))} <= set(found)
    assert all(tuple(k for k in range(causes) if k != one) in found for one in range(causes))
