"""Trials and references each keep the robot file that belongs to them, whichever simulator is asked."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.interfaces import Drive, Simulator
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.machine import parse_machine
from model.errors import GapError
from record.trial.trial import Trial
from robot.config.robot_file import load_robot
from robot.gap_report.trials import runs_of
from tests.gap.walks import walk

BEFORE = load_robot().text
AFTER = f"{BEFORE}\n[effects.force_bias.ML]\nz_n = -3.0\n"


def recorded_with(text: str, seed: int) -> Trial:
    trial = walk("tripod", 0.2, 6.0, noise_seed=seed)
    return replace(trial, header=replace(trial.header, robot_text=text))


def predicted_by(simulator: Simulator, trial: Trial) -> str:
    """Which of the two files a simulator uses for a trial."""
    own = simulator.predict(trial, (), Drive.COMMAND)
    for text, name in ((BEFORE, "before"), (AFTER, "after")):
        one = LeggedSimulator(parse_machine(text)).predict(trial, (), Drive.COMMAND)
        if np.array_equal(own, one, equal_nan=True):
            return name
    return "none of them"


@pytest.mark.parametrize(
    ("of_trial", "of_reference", "robot", "used"),
    [
        (AFTER, BEFORE, None, ("after", "before")),
        (BEFORE, BEFORE, AFTER, ("after", "before")),
        (BEFORE, BEFORE, None, ("before", "before")),
        (AFTER, "", None, ("after", "after")),
        (BEFORE, "", AFTER, ("after", "before")),
    ],
)  # fmt: skip
def test_references_keep_the_file_recorded_with_them(
    tmp_path: Path, of_trial: str, of_reference: str, robot: str | None, used: tuple[str, str]
) -> None:
    trial, reference = recorded_with(of_trial, 0), recorded_with(of_reference, 1)
    path = None
    if robot is not None:
        path = tmp_path / "robot.toml"
        path.write_text(robot, encoding="utf-8")
    runs = runs_of((trial,), (reference,), path)
    each, simulator = (*runs.trials, *runs.references), runs.simulator()
    assert tuple(predicted_by(simulator, one) for one in each) == used
    files: list[str] = []

    def make(trials: Sequence[Trial]) -> Simulator:
        text = trials[0].header.robot_text
        files.append("after" if text == AFTER else "before")
        return LeggedSimulator(parse_machine(text))

    runs.made_by(make)  # as the MuJoCo robot is made
    assert tuple(files) == tuple(dict.fromkeys(used))


def test_runs_without_any_robot_file_say_what_is_missing() -> None:
    runs = runs_of((recorded_with("", 0),), (recorded_with("", 1),))
    with pytest.raises(GapError, match=r'add robot = "FILE\.toml"'):
        runs.simulator()
