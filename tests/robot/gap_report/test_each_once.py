"""A recording counts once, whatever it is called and whenever it is said to have been taken."""

from dataclasses import replace

import numpy as np
import pytest

from model.errors import GapError
from record.trial.trial import Trial
from robot.gap_report.each_once import check_each_once
from tests.gap.bench_trials import MOTOR, servo_trial

FIRST = servo_trial(MOTOR, np.sin(np.arange(100) / 10))
OTHER = servo_trial(MOTOR, np.cos(np.arange(100) / 10))


def test_runs_that_differ_are_taken() -> None:
    check_each_once([FIRST, OTHER], ["one.csv", "other.csv"])


def test_runs_in_which_nothing_was_measured_are_for_others_to_refuse() -> None:
    empty = replace(FIRST, shaft_rad=np.full_like(FIRST.shaft_rad, np.nan))
    check_each_once([empty, empty], ["one.csv", "other.csv"])


@pytest.mark.parametrize(
    ("second", "name", "words"),
    [
        (FIRST, "one.csv", r"one\.csv is given twice"),
        (FIRST, "copy.csv", r"copy\.csv has the same readings as one\.csv"),
        (
            replace(FIRST, time_s=FIRST.time_s + 5.0),
            "late.csv",
            "may not be both a trial and a ref",
        ),
    ],
    ids=["the same file", "a copy", "a copy at another time"],
)
def test_a_recording_that_is_there_twice_is_refused(second: Trial, name: str, words: str) -> None:
    with pytest.raises(GapError, match=words):
        check_each_once([FIRST, OTHER, second], ["one.csv", "other.csv", name])
