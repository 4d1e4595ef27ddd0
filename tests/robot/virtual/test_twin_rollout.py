"""The MuJoCo robot as a simulator under diagnosis: the same walk again, and a cause found with it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.interfaces import Cause, Drive, Simulator
from model.errors import GapError
from record.trial.trial import Trial, write_trial
from robot.cli.main import run
from robot.config.robot_file import load_robot
from robot.virtual.twin_rollout import TwinRollout, twin_catalogue, twin_simulator
from tests.gap.walks import cause, command_trial

CONFIG = load_robot()
TEXT = CONFIG.text


def rolled(trial: Trial, *causes: Cause, seed: int | None = None) -> Trial:
    """What the MuJoCo robot measures, with the noise of good sensors if a seed is given."""
    made = TwinRollout(CONFIG)(trial, causes)
    if seed is None:
        return made
    rng = np.random.default_rng(seed)
    noise = trial.header.noise
    return replace(
        made,
        shaft_rad=made.shaft_rad + rng.normal(0, noise.shaft_rad, made.shaft_rad.shape),
        force_n=made.force_n + rng.normal(0, noise.force_n, made.force_n.shape),
        body_position_m=made.body_position_m + rng.normal(0, noise.body_position_m, (len(made.time_s), 3)),
        body_angles_rad=made.body_angles_rad + rng.normal(0, noise.body_angle_rad, (len(made.time_s), 3)),
        foot_m=made.foot_m + rng.normal(0, noise.foot_position_m, made.foot_m.shape),
    )  # fmt: skip


def test_a_walk_again_is_the_same_walk_and_stands_on_the_chain_s_ground() -> None:
    trial = command_trial("tripod", 0.2, 4.0)
    first, again = rolled(trial), rolled(trial)
    for name in ("shaft_rad", "force_n", "body_position_m", "foot_m"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    assert np.abs(first.shaft_rad - trial.command_rad).max() < 0.15
    assert first.force_n[:, :, 2].sum(axis=1).mean() == pytest.approx(6.5 * 9.80665, rel=0.02)
    assert np.abs(first.body_position_m[0, :2]).max() < 2e-3
    assert first.body_position_m[-1, 0] > 0.01  # it walks forward


def test_it_begins_where_the_trial_began() -> None:
    trial = command_trial("tripod", 0.2, 2.0)
    pose = np.tile([1.0, -0.5, 0.12], (len(trial.time_s), 1))
    angles = np.tile([0.0, 0.0, 0.7], (len(trial.time_s), 1))
    made = rolled(replace(trial, body_position_m=pose, body_angles_rad=angles))
    assert made.body_position_m[0, :2] == pytest.approx([1.0, -0.5], abs=2e-3)
    assert made.body_angles_rad[0, 2] == pytest.approx(0.7, abs=2e-3)


def test_causes_are_those_of_the_virtual_robot() -> None:
    ours: Simulator = twin_simulator(TEXT, ("force_bias", "command_delay"))
    assert [effect.name for effect in ours.effects] == ["command_delay", "force_bias"]
    trial = rolled(command_trial("tripod", 0.2, 3.0))
    base = ours.predict(trial, (), Drive.COMMAND)
    biased = ours.predict(
        trial, (cause("force_bias", 0.0, 0.0, -2.0, legs=("ML",)),), Drive.COMMAND
    )
    channel = [c.name == "force_z" and c.joint == "ML" for c in ours.channels]
    assert np.allclose((biased - base)[:, channel], -2.0, atol=1e-6)
    error = [c.name == "shaft_error" for c in ours.channels]
    late = ours.predict(trial, (cause("command_delay", 0.05),), Drive.COMMAND)
    assert np.abs(late[:, error]).max() > 1.5 * np.abs(base[:, error]).max()
    with pytest.raises(GapError, match="no effect of the MuJoCo robot"):
        twin_simulator(TEXT, ("coulomb_friction",))


def test_its_catalogue_is_the_chain_s_but_for_what_every_mujoco_robot_has() -> None:
    names = {effect.name for effect in twin_catalogue()}
    assert len(names) == 40
    assert not names & {"coulomb_friction", "tilt_coupling"}
    for effect in twin_catalogue():
        assert all(p.lower <= p.neutral <= p.upper for p in effect.parameters)


@pytest.mark.soak
def test_a_cause_is_named_with_the_mujoco_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = cause("com_offset", 0.02, 0.01)
    paths = []
    for number in range(3):
        bare = command_trial("tripod", 0.3, 4.0 + number)
        path = tmp_path / f"run{number}.parquet"
        write_trial(rolled(bare, wrong, seed=number), path)
        paths.append(str(path))
    told = tmp_path / "d.json"
    arguments = ["--sim", "mujoco", "--effects-only", "com_offset", "--json", str(told)]
    assert run(["gap", "diagnose", *paths, *arguments, "--jobs", "1"]) == 0
    assert "walks of" in capsys.readouterr().err
    found = json.loads(told.read_text())
    assert found["simulator"] == "mujoco"
    assert found["causes"][0]["effect"] == "com_offset"
    assert found["causes"][0]["parameters"]["x_m"] == pytest.approx(0.02, abs=0.002)
    assert found["gap"]["shrink"] > 0.9
