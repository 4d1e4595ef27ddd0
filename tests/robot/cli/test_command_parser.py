"""Options are spelled in full, and a mistake is answered by the command it was made in."""

import pytest

from robot.cli.main import run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["drive", "--arm"],
            "bigant drive: error: unrecognized arguments: --arm; did you mean --armed?",
        ),
        (["drive", "--gate", "tripod"], "--gate tripod; did you mean --gait?"),
        (["servo", "watch", "--prot", "x"], "bigant servo watch: error:"),
        (["gap"], "ACTION is one of: apply, demo, diagnose, effects, next"),
        (["drve"], "did you mean drive?"),
        (["gap", "diagnos"], "did you mean diagnose?"),
        (["force", "watch", "--seconds", "-1"], "--seconds: must be a positive number, not -1"),
        (["force", "bias", "--seconds", "0.1"], "--seconds: must be from 1 to 3600, not 0.1"),
        (["force", "calibrate", "--rounds", "51"], "must be a whole number from 1 to 50, not 51"),
        (["drive", "--steer", "2"], "--steer: must be from -1 to 1, not 2"),
        (["gap", "diagnose", "a", "--jobs", "0"], "must be a whole number 1 or more, not 0"),
        (["drive", "--seed", "-1"], "--seed: must be a whole number 0 or more, not -1"),
        (["sim", "serve", "--baud", "12345"], "must be one of 9600, 57600"),
        (
            ["servo", "watch", "--port", "x", "--rate-hz", "1e9"],
            "--rate-hz: must be a whole number from 1 to 500 Hz, not 1e9",
        ),
    ],
)
def test_a_mistake_is_answered_by_its_own_command(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        run(words)
    assert caught.value.code == 2
    assert said in capsys.readouterr().err
