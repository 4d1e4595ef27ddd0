"""Errors are what they were when they come from another process."""

import pickle

import pytest

from model.errors import BigantError, BusError, ConfigError, ConnectionLost, GaitRefused, GapError

ERRORS = (
    ConfigError("leg.crank", "must be above 0"),
    GaitRefused("servo.max_speed", 5.0, 4.0, "rad/s"),
    BusError("no servo answers", port="/dev/x", ids=(1, 2), register="goal_position", code=-3001),
    ConnectionLost("the port is gone", port="/dev/x"),
    GapError("no usable data"),
)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_comes_from_another_process_as_it_was(error: BigantError) -> None:
    came = pickle.loads(pickle.dumps(error))
    assert type(came) is type(error)
    assert str(came) == str(error)
    assert vars(came) == vars(error)
