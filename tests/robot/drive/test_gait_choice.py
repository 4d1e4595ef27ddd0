"""A walk that is too long for the servos' turn counters is announced."""

import pytest

from gaits.catalog import make_gait
from robot.config.robot_file import load_robot
from robot.drive.gait_choice import turns_note

ROBOT = load_robot().parameters


@pytest.mark.parametrize("cycles", [0.0, 3.0, 251.0])
def test_a_walk_that_fits_is_not_mentioned(cycles: float) -> None:
    assert turns_note(make_gait("tripod", ROBOT), cycles) == ""


def test_a_longer_walk_is_said_to_end_before() -> None:
    note = turns_note(make_gait("tripod", ROBOT), 350.0)
    assert note.startswith("350 cycles turn a shaft by 350 turns")
    assert "has 252 at most" in note
    assert "TURNS_USED" in note
