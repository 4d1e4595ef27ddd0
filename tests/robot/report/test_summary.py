"""The summary of a run in words: nothing that was not, and why it stopped."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.values.faults import Fault, FaultKind, StopReason
from model.values.tick import Mode
from record.log.blocks.read import read_log
from record.log.recording import Recording, join_recordings, thin_recording
from robot.console.table import number_text, row_lines
from robot.report.run_totals import RunTotals
from robot.report.summary import Summary, summarise_totals
from robot.report.summary_text import summary_rows

GOLDEN = Path(__file__).resolve().parents[2] / "replay" / "golden" / "tripod.mcap"
HOT = Fault(FaultKind.SERVO_HOT, "MR", "75 degC, limit 70 degC")
SILENT = Fault(FaultKind.SERVO_SILENT, "HL", "no sound answer for 1 reads")


@pytest.fixture(scope="module")
def walk() -> Recording:
    """A recorded walk with dead reckoning for its truth: the robot of the log had none."""
    log = read_log(GOLDEN)
    half = log.dead_reckoning_pose[:, 2] / 2
    nothing = np.zeros_like(half)
    return replace(
        log,
        truth_position_W=np.column_stack([log.dead_reckoning_pose[:, :2], nothing]),
        truth_quaternion_xyzw=np.column_stack([nothing, nothing, np.sin(half), np.cos(half)]),
        truth_velocity_B=log.predicted_velocity_B,
    )


def summarise(log: Recording) -> Summary:
    totals = RunTotals()
    totals.add(log)
    return summarise_totals(totals, log)


def rows_of(log: Recording) -> dict[str, str]:
    return dict(summary_rows(summarise(log)))


def test_a_robot_that_did_not_walk_says_so_once_and_shows_nothing_that_is_not_known(
    walk: Recording,
) -> None:
    still = replace(walk, mode=np.full_like(walk.mode, Mode.HOLD.value))
    text = "\n".join(row_lines(summary_rows(summarise(still))))
    assert "nan" not in text
    assert text.count("did not walk") == 1
    assert not {"distance", "mean speed", "turned", "predicted velocity, RMSE"} & set(
        rows_of(still)
    )
    assert {"distance", "mean speed", "turned", "predicted velocity, RMSE"} <= set(rows_of(walk))


def test_a_log_without_forces_says_so_and_has_no_row_of_them(walk: Recording) -> None:
    blind = replace(walk, force_n=np.full_like(walk.force_n, np.nan))
    assert rows_of(blind)["foot forces"] == "none measured"
    assert [label for label in rows_of(blind) if "foot force, RMSE" in label] == []
    assert "foot forces" not in rows_of(walk)


def test_long_rows_go_on_below_themselves_in_a_terminal(walk: Recording) -> None:
    rows = summary_rows(summarise(walk))
    whole, broken = row_lines(rows), row_lines(rows, 60)
    assert max(map(len, whole)) > 60 >= max(map(len, broken))
    assert " ".join(broken).split() == " ".join(whole).split()


def test_rows_stand_alone_and_say_the_part_of_the_run(walk: Recording) -> None:
    rows = rows_of(walk)
    assert not [label for label in rows if label.startswith(" ")]
    assert not [text for text in rows.values() if "  " in text], "a page makes one space of two"
    for label in ("distance", "mean speed", "turned", "estimator's velocity, RMSE"):
        assert "walking)" in rows[label]
    assert "(walking)" in rows["drift of dead reckoning"]
    assert "(whole run)" in rows["drift of dead reckoning"]


def test_the_drift_of_the_walk_leaves_out_what_was_before_it(walk: Recording) -> None:
    walking = np.flatnonzero(walk.mode == Mode.WALK.value)
    pose = walk.dead_reckoning_pose.copy()
    pose[: walking[0], 0] -= 1.0
    found, jumped = summarise(walk), summarise(replace(walk, dead_reckoning_pose=pose))
    assert jumped.walk_drift_m == pytest.approx(found.walk_drift_m)
    assert jumped.drift_m == pytest.approx(1.0, abs=0.1)


def test_a_stopped_run_says_why_when_and_what_went_wrong_last(walk: Recording) -> None:
    reason = walk.stop_reason.copy()
    reason[-5:] = StopReason.SERVO_FAULT.value
    at = len(reason) - 5
    faults = ((at - 2, SILENT), (at, SILENT), (at, HOT), (at + 1, HOT))
    rows = rows_of(replace(walk, stop_reason=reason, faults=faults))
    assert "beyond a limit" in rows["stopped because"]
    assert "(MR: 75 degC, limit 70 degC)" in rows["stopped because"], "and not the silent servo"
    assert f"from {walk.t_s[at]:.2f} s on" in rows["stopped because"]
    assert rows["last faults"] == (
        f"SERVO_HOT MR: 75 degC, limit 70 degC at {walk.t_s[at + 1]:.2f} s; "
        f"SERVO_SILENT HL: no sound answer for 1 reads at {walk.t_s[at]:.2f} s"
    )


def test_a_run_that_ended_as_wished_gives_no_cause(walk: Recording) -> None:
    reason = walk.stop_reason.copy()
    reason[-5:] = StopReason.OPERATOR.value
    assert "stopped because" not in rows_of(replace(walk, stop_reason=reason))


def test_faults_count_ticks_and_not_legs(walk: Recording) -> None:
    other = replace(SILENT, source="MR")
    faults = ((3, SILENT), (3, other), (4, SILENT), (9, HOT))
    assert rows_of(replace(walk, faults=faults))["faults"] == (
        "SERVO_SILENT in 2 ticks, SERVO_HOT in 1 tick"
    )


def test_faults_stay_at_their_ticks_in_joined_and_thinned_logs(walk: Recording) -> None:
    log = replace(walk, faults=((7, HOT),))
    both = join_recordings([log, log], "")
    assert [row for row, _ in both.faults] == [7, 7 + len(log.t_s)]
    thin = thin_recording(log, 3)
    assert thin.t_s[thin.faults[0][0]] == walk.t_s[6]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (-0.04, "0.0"),
        (0.0, "0.0"),
        (-0.06, "-0.1"),
        (np.nan, "-"),
        (-np.inf, "-"),
        (12.345, "12.3"),
    ],
)
def test_what_rounds_to_zero_has_no_minus_and_what_is_unknown_is_a_dash(
    value: float, text: str
) -> None:
    assert number_text(value, 1) == text
    assert number_text(value, 1, 8) == text.rjust(8)
