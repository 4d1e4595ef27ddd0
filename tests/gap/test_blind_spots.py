"""What runs cannot show, of a toy whose angles are compared with commands and that follows commands."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from gap.coverage.blind_spots import COMMANDS, BlindSpot, MissingAt, blind_spots
from gap.diagnosis.alone import each_alone
from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive, Observation
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from robot.gap_report.summary import summary_lines
from tests.gap.toy import Toy, toy_case, toy_references, toy_trial

SOFT = Cause("stiffness", ("c",), (0.8,))


@dataclass(eq=False)
class Follower(Toy):
    """A toy that can be simulated from commands only if there are some."""

    def observe(self, trial: Trial) -> Observation:
        seen = super().observe(trial)
        values = seen.values.copy()
        values[:, :3] += 0.0 * trial.command_rad
        return replace(seen, values=values, weight=np.isfinite(values) * 1.0)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        values = super().predict(trial, causes, drive).copy()
        values[:, :3] += 0.0 * trial.command_rad
        if drive is Drive.COMMAND:
            values += 0.0 * trial.command_rad.sum(axis=1, keepdims=True)
        return values


def commanded(trial: Trial) -> Trial:
    return replace(trial, command_rad=trial.shaft_rad)


def without_force(trial: Trial, joint: int) -> Trial:
    force = trial.force_n.copy()
    force[:, joint] = np.nan
    return replace(trial, force_n=force)


def test_what_commands_would_show_is_to_be_seen_with_commands() -> None:
    run = toy_trial()
    assert blind_spots(Follower(), [commanded(run)]).effects == ()
    spots = blind_spots(Follower(), [run])
    assert spots.missing == (COMMANDS,)
    assert spots.effects == tuple(
        BlindSpot(name, (COMMANDS,)) for name in ("delay", "lag", "offset")
    )
    assert spots.comparable


def test_one_run_with_commands_is_enough() -> None:
    run = toy_trial()
    assert blind_spots(Follower(), [run, commanded(toy_trial(seed=1))]).missing == ()


def test_what_is_missing_at_one_joint_hides_its_effects_there_and_nowhere_else() -> None:
    run = without_force(toy_trial(), 1)
    spots = blind_spots(Toy(), [run])
    assert spots.missing == ()
    assert spots.at_joints == (MissingAt(("force",), ("b",)),)
    assert spots.effects == (BlindSpot("bias", ("force",), ("b",)),)
    assert blind_spots(Toy(), [run, toy_trial(seed=1)]).at_joints == ()


def test_nothing_that_was_measured_can_be_compared() -> None:
    run = toy_trial()
    nothing = replace(run, **{
        name: np.full_like(getattr(run, name), np.nan)
        for name in ("shaft_rad", "force_n", "body_position_m")
    })  # fmt: skip
    assert not blind_spots(Toy(), [nothing]).comparable


@pytest.fixture(scope="module")
def blindly() -> Diagnosis:
    """Runs without commands, diagnosed."""
    return diagnose(toy_case([SOFT], 3), Follower(), toy_references(3))


def test_without_commands_each_stage_that_judges_is_fed_what_was_measured(
    blindly: Diagnosis,
) -> None:
    far = blindly.far
    assert not far.end_to_end
    assert [one.effect for one in blindly.causes] == ["stiffness"]
    assert far.before > 1.5 > far.after > 0.5
    assert far.shrink > 0.9
    assert np.isnan([one.end_to_end for one in blindly.where.stages]).all()
    assert blindly.where.joints[0].rms > 0.1


def test_it_is_said_that_nothing_was_judged_end_to_end(blindly: Diagnosis) -> None:
    paths = [Path(f"{number}.parquet") for number in range(10)]
    said = " ".join(" ".join(summary_lines(blindly, paths)).split())
    words = "without commands these runs cannot be judged end to end: each stage was fed what was measured"
    assert words in said
    assert "(0 N)" not in said


def test_runs_with_commands_are_judged_end_to_end() -> None:
    trials, references = (
        [commanded(one) for one in runs] for runs in (toy_case(), toy_references())
    )
    assert make_study(trials, Follower(), references).judging is Drive.COMMAND
    assert make_study(trials, Follower(), toy_references()).judging is Drive.MEASURED, "no baseline"
    assert make_study(toy_case(), Toy()).judging is Drive.COMMAND, "one that needs no commands"


def test_effects_by_themselves_are_not_fitted_without_commands() -> None:
    with pytest.raises(GapError, match="these runs have no commands"):
        each_alone(toy_case(), Follower(), [("lag",)])


def test_commands_of_one_joint_are_missed_there() -> None:
    run = commanded(toy_trial())
    command = run.command_rad.copy()
    command[:, 1] = np.nan
    spots = blind_spots(Follower(), [replace(run, command_rad=command)])
    assert spots.at_joints == (MissingAt((COMMANDS,), ("b",)),)
    assert spots.effects == (BlindSpot("offset", (COMMANDS,), ("b",)),)
