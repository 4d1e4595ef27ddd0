"""Effects of a robot file in controller, replay and virtual robot mean what they mean to a diagnosis."""

import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.machines.legged.chain import LeggedChain
from gap.machines.legged.inputs import make_inputs
from model.effects.grid import body_velocity
from model.effects.settings import settings_of
from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frame import solve_frame
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.legs import FootForces
from record.trial.trial import read_trial
from robot.cli.main import run
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.control.effect_uses import USES, Use, unused_notes
from robot.control.effects import OF_THE_FEET, EffectsBeside, model_of
from robot.virtual.file_twin import file_twin
from robot.virtual.twin_run import make_twin
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import parse_effect
from tests.gap.test_correction import corrected, sized
from tests.gap.walks import cause, machine, walk

ROOT = Path(__file__).resolve().parents[3]
CONFIG = load_robot()
# Keys of the file change the nominal model, which tests of the model cover; a foot that gives remembers
# more than one frame, and a lag has a test of its own.
IN_MODEL = [
    name
    for name, use in USES.items()
    if use is Use.MODEL
    and name
    not in {
        "leg_stiffness", "foot_friction", "friction_level", "friction_anisotropy", "hip_mount_offset",
        "leg_flex", "inertia_lag", "stick_slip",
    }
]  # fmt: skip


def with_effects(*causes: Cause) -> RobotConfig:
    return parse_robot(corrected(CONFIG.text, *causes))


def in_chain(*causes: Cause) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Loads, velocities and frames of the chain fed with the shafts of a walk."""
    trial = walk("metachronal", 0.1, 8.0)
    inputs = make_inputs(trial, machine().names)
    settings = settings_of(causes, machine().names, machine().size)
    # shafts measured, forces not: loads are the model's own
    known = replace(inputs, force_n=np.full_like(inputs.force_n, np.nan))
    found = LeggedChain(machine()).walk(known, settings, Drive.MEASURED)
    return found.standing.load_n, found.sliding.velocity_B, inputs.shaft_rad


def in_frames(config: RobotConfig) -> tuple[FloatArray, FloatArray]:
    """The same, frame by frame, as the controller asks."""
    trial = walk("metachronal", 0.1, 8.0)
    inputs = make_inputs(trial, machine().names)
    model = model_of(config)
    assert model is not None
    rate = np.gradient(inputs.shaft_rad, inputs.grid.period_s, axis=0)
    pose = np.column_stack([inputs.body_m[:, :2], inputs.body_rad[:, 2]])
    before = body_velocity(inputs.grid, pose)
    period_s = inputs.grid.period_s
    rows = range(0, len(rate), 7)
    loads, velocities = [], []
    for i in rows:
        answer = model.solve(inputs.shaft_rad[i], rate[i], pose[i], before[max(i - 1, 0)], period_s)
        loads.append(answer.contact.support.load_n)
        velocities.append(answer.contact.traction.velocity_B)
    return np.array(loads), np.array(velocities)


@cache
def without_effects() -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """What each effect is compared with, in the controller and in the chain."""
    nothing = cause("payload", 0.0, 0.0, 0.0)
    return in_frames(with_effects(nothing)), in_chain()


@pytest.mark.parametrize("name", IN_MODEL)
def test_an_effect_does_in_the_controller_what_it_does_in_the_chain(name: str) -> None:
    wrong = sized(name, ("ML",)) if name == "link_length" else sized(name)
    every = slice(None, None, 7)
    plain, plain_theirs = without_effects()
    ours, theirs = [plain, in_frames(with_effects(wrong))], [plain_theirs, in_chain(wrong)]
    change = [ours[1][i] - ours[0][i] for i in (0, 1)]
    wanted = [(theirs[1][i] - theirs[0][i])[every] for i in (0, 1)]
    told = False
    if name == "chassis_twist":  # rows that are pushed aside remember more than one frame
        change, wanted = change[:1], wanted[:1]
    for got, want in zip(change, wanted, strict=True):
        inner = slice(3, -3)  # the chain's filters are not what they are elsewhere at the ends
        got, want = got[inner], want[inner]
        if np.abs(want).max() < 1e-6:
            assert np.abs(got).max() < 1e-4
            continue
        told = True
        # contacts switch within the chain's filters: the bulk must agree
        scale = np.sqrt(np.mean(want**2))
        assert np.median(np.abs(got - want)) < 0.15 * scale
        assert np.corrcoef(got.ravel(), want.ravel())[0, 1] > 0.9
    assert told


def test_a_file_without_effects_has_no_other_model() -> None:
    assert model_of(CONFIG) is None


def test_an_effect_at_neutral_is_the_model_of_the_loop() -> None:
    model = model_of(with_effects(cause("payload", 0.0, 0.0, 0.0)))
    assert model is not None
    own = CONFIG.parameters
    kinematics = leg_kinematics(own)
    rng = np.random.default_rng(0)
    for _ in range(20):
        angle, rate = rng.uniform(-0.8, 0.8, 6), rng.uniform(0.2, 0.6, 6)
        feet = kinematics.feet(angle, rate)
        plain = solve_frame(feet, own.contact, own.body.mass * 9.80665)
        found = model.solve(angle, rate, np.zeros(3), np.full(3, np.nan), 0.0)
        assert np.allclose(found.feet.position_m, feet.position_m, atol=1e-12)
        assert np.allclose(found.feet.velocity_m_s, feet.velocity_m_s, atol=1e-6)
        for one, other in (
            (found.contact.support.load_n, plain.support.load_n),
            (found.contact.traction.force_B, plain.traction.force_B),
            (found.contact.traction.slip_B, plain.traction.slip_B),
        ):
            assert np.allclose(one, other, atol=1e-4, equal_nan=True)
        assert found.contact.support.slope_x == pytest.approx(plain.support.slope_x, abs=1e-9)


def test_a_mass_is_held_and_a_turned_body_meets_the_slope_from_its_side() -> None:
    still, before = np.full(6, 0.4), np.array([0.05, 0.0, 0.0])
    lag = model_of(with_effects(cause("inertia_lag", 0.1)))
    assert lag is not None
    at = lag.solve(np.zeros(6), still, np.zeros(3), np.full(3, np.nan), 0.01)
    later = lag.solve(np.zeros(6), still, np.zeros(3), before, 0.1)
    aim, got = at.contact.traction.velocity_B, later.contact.traction.velocity_B
    assert aim[0] < got[0] < before[0]
    contact = machine().contact
    mass = 0.1 * contact.mu.mean() * machine().size.weight_n / 0.02
    pushed = later.contact.traction.force_B[:, 0].sum()
    assert pushed == pytest.approx(mass * (got[0] - before[0]) / 0.1, rel=1e-6)
    slope = model_of(with_effects(cause("ground_slope", 0.05, 0.0)))
    assert slope is not None
    straight = slope.solve(
        np.zeros(6), still, np.zeros(3), before, 0.01
    ).contact.traction.velocity_B
    turned = slope.solve(
        np.zeros(6), still, np.array([0.0, 0.0, np.pi / 2]), before, 0.01
    ).contact.traction.velocity_B
    assert straight[0] < aim[0] - 5e-5  # downhill is behind
    assert turned[1] > 5e-5  # and then to the left: the slope rises to the body's right
    assert turned[0] == pytest.approx(aim[0], abs=2e-5)


@pytest.mark.parametrize("name", sorted(OF_THE_FEET))
def test_what_moves_feet_is_in_the_estimators_feet_and_not_added_again(name: str) -> None:
    config = with_effects(nothing := cause("payload", 0.0, 0.0, 0.0))
    shifted = replace(config, effects=(sized(name, ("ML",)), nothing))
    rate, no_forces = np.full(6, 0.4), FootForces(0, np.zeros((6, 3)), np.zeros(6, dtype=bool))
    feet = []
    for one in (config, shifted):
        beside = EffectsBeside(one, FrictionLaw.VISCOUS)
        _, tick = beside.step(None, 0, np.full(6, 0.2), rate, no_forces)
        feet.append(tick.answer.feet.position_m)
        assert np.abs(tick.added.velocity_B).max() == 0.0
        assert np.abs(tick.added.load_n).max() == 0.0
    assert np.abs(feet[1] - feet[0]).max() > 1e-4


def test_readings_are_undone_and_silent_legs_stay_silent() -> None:
    model = model_of(
        with_effects(
            cause("force_gain", 1.2, legs=("ML",)),
            cause("force_bias", 1.0, -1.0, 2.0, legs=("ML",)),
            cause("force_rotation", 0.3, legs=("FR",)),
            cause("force_drift", 0.1, legs=("HL",)),
            cause("force_cross_talk", 0.1, -0.2, legs=("FL",)),
        )
    )
    assert model is not None
    truth = np.arange(18, dtype=float).reshape(6, 3)
    reading = truth.copy()
    reading[1] = 1.2 * truth[1] + [1.0, -1.0, 2.0]
    c, s = np.cos(0.3), np.sin(0.3)
    reading[2, :2] += [0.1 * truth[2, 2], -0.2 * truth[2, 2]]
    reading[5, :2] = [c * truth[5, 0] + s * truth[5, 1], c * truth[5, 1] - s * truth[5, 0]]
    reading[0, 2] += 0.1 * 20.0
    reading[3] = np.nan
    valid = np.isfinite(reading).all(axis=1)
    found = model.true_forces(FootForces(7, reading, valid), 20.0)
    assert np.allclose(found.force_n[valid], truth[valid])
    assert np.isnan(found.force_n[3]).all()
    assert (found.t_ns, found.valid.tolist()) == (7, valid.tolist())
    unknown = model.solve(np.full(6, np.nan), np.zeros(6), np.zeros(3), np.full(3, np.nan), 0.01)
    assert not unknown.contact.support.converged
    assert not unknown.contact.traction.valid


@pytest.mark.soak
def test_a_controller_with_effects_loads_nothing_of_diagnosis_or_simulation() -> None:
    code = """
import sys
from robot.config.robot_file import load_robot, parse_robot
from robot.control.controller import Controller
text = load_robot().text + "[effects.payload.all]\\nmass_kg = 0.5\\n"
Controller(parse_robot(text), (None,) * 6, armed=False)
print({name.split(".")[0] for name in sys.modules} & {"gap", "sim_hw", "mujoco"})
"""
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert ran.stdout == "set()\n"


def test_drive_and_replay_run_with_the_effects(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, log = tmp_path / "corrected.toml", tmp_path / "run.mcap"
    text = corrected(CONFIG.text, cause("payload", 0.8, 0.1, 0.05), cause("command_delay", 0.05))
    file.write_text(text, encoding="utf-8")
    arguments = ["drive", "--readonly", "--duration", "0.3", "--virtual-time", "--robot", str(file)]
    assert run([*arguments, "--log", str(log)]) == 0
    assert "command_delay of the robot file is not in the model here" in capsys.readouterr().err
    assert run(["replay", str(log)]) == 0
    assert "the same in every bit" in capsys.readouterr().out
    assert run(["replay", str(log), "--robot", "config/bigant.toml"]) == 1
    assert "first difference: " in capsys.readouterr().out


def test_the_virtual_robot_has_the_effects_of_its_file(tmp_path: Path) -> None:
    wrong = (
        cause("command_delay", 0.05), cause("force_bias", 0.0, 0.0, -2.0, legs=("ML", "FR")),
        cause("payload", 0.8, 0.1, 0.0), cause("foot_friction", 0.5, legs=("HL",)),
    )  # fmt: skip
    config = with_effects(*wrong)
    twin = make_twin(config, (), 3)
    words = (
        "command_delay:delay_s=0.05", "force_bias@ML:z_n=-2", "force_bias@FR:z_n=-2",
        "payload:mass_kg=0.8,x_m=0.1", "foot_friction@HL:ratio=0.5",
    )  # fmt: skip
    other = make_twin(CONFIG, tuple(parse_effect(word, EFFECTS) for word in words), 3)
    assert twin.plant.drive.delay_s == other.plant.drive.delay_s == 0.05
    assert np.array_equal(twin.sensors.force_bias, other.sensors.force_bias)
    assert twin.plant.payload == other.plant.payload
    assert np.allclose(twin.plant.mu, other.plant.mu)
    driven = file_twin(config, 0)
    assert driven is not None
    assert driven.plant.drive.delay_s == 0.05
    assert file_twin(CONFIG, 0) is None
    with pytest.raises(ConfigError, match="is in the robot file already"):
        make_twin(config, (parse_effect("command_delay:delay_s=0.02", EFFECTS),), 0)
    file, out = tmp_path / "corrected.toml", tmp_path / "walk.parquet"
    file.write_text(config.text, encoding="utf-8")
    assert (
        run(["sim", "run", "--fast", "--seconds", "1.5", "--robot", str(file), "--out", str(out)])
        == 0
    )
    made = read_trial(out)
    load = np.nanmean(made.force_n[:, :, 2].sum(axis=1))
    assert load == pytest.approx((6.5 + 0.8) * 9.80665 - 4.0, rel=0.02)  # two biases of -2 N


def test_notes_name_what_the_controller_does_not_use() -> None:
    notes = unused_notes((cause("pose_delay", 0.05), cause("payload", 0.5, 0.0, 0.0)))
    assert len(notes) == 1
    assert "pose_delay" in notes[0]
