"""Diagnosis of a robot whose legs have several joints: effects by joint, a fault that MuJoCo walked."""

import json
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap.interfaces import Cause, Drive, Scope, place_words
from gap.machines.legged.simulator import LeggedSimulator
from gap.residuals.hunting import hunting_of, without_hunting
from gap.residuals.parts import whole_parts
from gap.search.candidates import candidates_of
from model.effects.causes import check_cause
from model.effects.grid import make_grid
from model.effects.machine import LeggedMachine, parse_machine
from model.effects.settings import settings_of
from model.effects.shafts import feet, load_torque, shaft_give, springing
from model.errors import ConfigError, GapError
from model.kinematics.chain import ChainKinematics
from model.values.parameters import ChainParameters
from record.chain_file import complete
from record.log.from_trial import write_trial_log
from record.trial.column_map import read_column_map
from record.trial.import_table import import_tables
from record.trial.trial import Trial
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FAULT = ("LM_femur", 0.06)
TURNS = (0.0, 6.0, 10.0, 8.0)  # the last one with the fault


def machine() -> LeggedMachine:
    return parse_machine(complete((EXAMPLES / "hexapod18.toml").read_text("utf-8"), EXAMPLES))


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> tuple[tuple[Path, Trial], ...]:
    """Healthy walks and one with an encoder that is off, as logs and as trials."""
    folder = tmp_path_factory.mktemp("chain")
    made = []
    for seed, turn_deg in enumerate(TURNS):
        fault = FAULT if seed == len(TURNS) - 1 else ("", 0.0)
        trial = walked(folder / f"walk{seed}.csv", 6.0, turn_deg, seed, fault)
        log = folder / f"walk{seed}.mcap"
        write_trial_log(trial, log)
        made.append((log, trial))
    return tuple(made)


def walked(table: Path, cycles: float, *more: object) -> Trial:
    """The trial of a walk that the example makes."""
    walk: Any = runpy.run_path(str(EXAMPLES / "chain_walk.py"))["walk"]
    walk("hexapod18", table, cycles, *more)
    (one,) = import_tables(table, read_column_map(table.with_suffix(".map.toml")))
    assert one.trial is not None
    return one.trial


@pytest.fixture(scope="module")
def short_trial(tmp_path_factory: pytest.TempPathFactory) -> Trial:
    """One cycle of a healthy walk."""
    return walked(tmp_path_factory.mktemp("chain") / "short.csv", 1.0, 0.0, 0)


def test_effects_touch_joints_or_legs_and_are_those_that_chains_can_have() -> None:
    simulator = LeggedSimulator(machine())
    names = machine().names
    known = {effect.name: effect for effect in simulator.effects}
    assert known.keys().isdisjoint({"link_length", "foot_rolling"})
    of_joints = {n for n, e in known.items() if Scope.JOINT in e.scopes and e.parts == names.joints}
    assert of_joints == {
        "servo_lag", "servo_speed_limit", "servo_compliance", "servo_compliance_beyond_encoder",
        "gear_backlash", "gear_backlash_in_loop", "gear_backlash_dragged",
        "gear_backlash_beyond_encoder",
        "joint_friction", "shaft_zero_offset", "encoder_scale",
    }  # fmt: skip
    places = {(one.effect.name, one.joints) for one in candidates_of(simulator)}
    assert ("shaft_zero_offset", ("LM_femur",)) in places
    assert ("leg_stiffness", ("LM",)) in places
    assert ("leg_stiffness", ("LM_femur",)) not in places
    with pytest.raises(GapError, match="'LM' is no leg"):
        check_cause(
            Cause("shaft_zero_offset", ("LM",), (0.1,)), known["shaft_zero_offset"], names.joints
        )
    assert len(simulator.channels) == 18 + 8 * 6 + 15


def test_loads_turn_joints_as_the_jacobian_says() -> None:
    robot, rng = machine(), np.random.default_rng(0)
    settings = settings_of([Cause("servo_compliance", (), (0.02,))], robot.names, robot.size)
    simulator = LeggedSimulator(robot)
    grid = make_grid(np.arange(200) / 100)
    shape = grid.frames
    angle, force = rng.uniform(-0.5, 0.5, (shape, 18)), rng.uniform(-5, 5, (shape, 6, 3))
    signals = feet(robot, grid, angle, settings).signals
    assert isinstance(robot.leg, ChainParameters)
    slope = ChainKinematics(robot.leg).jacobian(angle)
    want = np.einsum("wnij,wni->wj", slope, force)  # virtual work
    assert np.allclose(load_torque(signals, force), want)
    compliance = np.full(18, 0.02)
    # a force along x turns the joints, and they move the foot: the same give both ways
    turned = springing(signals, compliance, force[..., 0])
    give = shaft_give(signals, compliance)
    alone = np.zeros_like(force[..., 0])
    alone[:, 2] = 1.0
    moved = np.einsum("wnj,wj->wn", slope[:, :, 0], springing(signals, compliance, alone))
    assert np.allclose(moved[:, 2], give[:, 2])
    assert turned.shape == angle.shape
    assert simulator.joints == robot.names.joints


@pytest.mark.parametrize("drive", list(Drive))
def test_every_effect_predicts_and_neutral_ones_change_nothing(
    short_trial: Trial, drive: Drive
) -> None:
    simulator, trial = LeggedSimulator(machine()), short_trial
    plain = simulator.predict(trial, (), drive)
    assert np.isfinite(plain[:, :18]).all()
    for effect in simulator.effects:
        place = () if Scope.ALL in effect.scopes else ((effect.parts or simulator.joints)[1],)
        neutral = tuple(parameter.neutral for parameter in effect.parameters)
        if neutral:
            same = simulator.predict(trial, (Cause(effect.name, place, neutral),), drive)
            assert np.array_equal(same, plain, equal_nan=True), effect.name
        values = tuple(
            min(max(p.neutral + 0.2 * p.spread, p.lower), p.upper) for p in effect.parameters
        )
        got = simulator.predict(trial, (Cause(effect.name, place, values),), drive)
        assert got.shape == plain.shape, effect.name


@pytest.mark.soak
def test_an_encoder_that_is_off_is_named_with_its_joint_and_size(
    walks: tuple[tuple[Path, Trial], ...], tmp_path: Path
) -> None:
    *healthy, (faulty, _) = walks
    out, corrected = tmp_path / "d.json", tmp_path / "corrected.toml"
    references = [str(log) for log, _ in healthy]
    words = ["gap", "diagnose", str(faulty), "--reference", *references, "--jobs", "1"]
    assert cli.run([*words, "--json", str(out)]) == ExitCode.OK
    named = json.loads(out.read_text("utf-8"))["causes"][0]
    assert place_words(named["effect"], named["legs"]) == "shaft_zero_offset at LM_femur"
    (value,) = named["parameters"].values()
    assert value == pytest.approx(FAULT[1], abs=0.015)
    # into the robot file, which stays complete
    assert cli.run(["gap", "apply", str(out), "--out", str(corrected), "--anyway"]) in {
        ExitCode.OK, ExitCode.VERDICT_FAILED,
    }  # fmt: skip
    (effect,) = parse_robot(corrected.read_text("utf-8")).effects
    assert (effect.effect, effect.joints) == ("shaft_zero_offset", ("LM_femur",))
    # and the estimator believes it
    words = ["odom", str(faulty), "--robot", str(corrected)]
    assert cli.run(words) == ExitCode.OK
    assert cli.run(["gap", "next", str(out)]) == ExitCode.USAGE  # no runs to propose


def test_a_robot_file_may_have_effects_of_joints_and_legs(tmp_path: Path) -> None:
    text = (EXAMPLES / "hexapod18.toml").read_text("utf-8")
    lab = tmp_path / "lab.toml"
    (tmp_path / "hexapod18.xml").write_bytes((EXAMPLES / "hexapod18.xml").read_bytes())
    own = "[effects.shaft_zero_offset.LF_tibia]\noffset_rad = 0.1\n"
    own += "[effects.leg_length.LF]\noffset_m = 0.001\n"
    lab.write_text(text + own, encoding="utf-8")
    assert len(load_robot(lab, driven=False).effects) == 2
    for wrong, words in (
        ("[effects.shaft_zero_offset.LF]\noffset_rad = 0.1\n", "places are all, LF_coxa"),
        ("[effects.leg_length.LF_coxa]\noffset_m = 0.1\n", "places are all, LF, LM"),
        ("[effects.link_length.all]\ncrank_m = 0.001\n", "correct the model"),
    ):
        lab.write_text(text + wrong, encoding="utf-8")
        with pytest.raises(ConfigError, match=words):
            load_robot(lab, driven=False)


def test_a_joint_that_hunts_hides_its_own_readings_and_where_the_foot_of_its_leg_is(
    walks: tuple[tuple[Path, Trial], ...],
) -> None:
    trials = [trial for _, trial in walks]
    known = trials[:3]
    joint = known[0].header.joints.index("LM_femur")
    time_s = trials[0].time_s
    shaft = trials[0].shaft_rad.copy()
    # by half of each second, as if unloaded then
    shaft[:, joint] += 0.05 * (np.mod(time_s, 1.0) < 0.5) * np.sin(2 * np.pi * 12.0 * time_s)
    seen = replace(trials[0], shaft_rad=shaft)
    found = hunting_of([seen], known)
    assert [one.joint for one in found] == ["LM_femur"]
    simulator = LeggedSimulator(machine())
    (part,) = whole_parts(simulator, [seen])
    (hidden,) = without_hunting(simulator.channels, {"shaft_error"}, [seen], [part], found)
    changed = np.any(hidden.observation.weight != part.observation.weight, axis=0)
    names = {(c.name, c.joint) for c, on in zip(simulator.channels, changed, strict=True) if on}
    assert names == {("shaft_error", "LM_femur"), *((f"foot_{axis}", "LM") for axis in "xyz")}
