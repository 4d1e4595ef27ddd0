"""Joints that hunt between the flanks of a play: found in readings, not compared, and named."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.delegate import Without
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.diagnose import diagnose_study
from gap.interfaces import Cause
from gap.residuals.hunting import Hunting, hunting_of, without_hunting
from gap.residuals.parts import whole_parts
from gap.search.candidates import at_hunting, candidates_of
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from robot.campaign.case import read_case
from robot.cli.main import run as command
from robot.gap_report.summary import summary_lines
from tests.gap.test_forms import STANDING
from tests.gap.walks import diagnosed_among, simulator, walk
from tests.soaked import THOROUGH

IN_LOOP = "gear_backlash_in_loop"
LAG = Cause("servo_lag", (), (0.05,))
KEPT = {"gear_backlash", "servo_lag", "leg_stiffness", "friction_level"}
ML = 1


def swung(trial: Trial, angle_rad: FloatArray) -> Trial:
    shaft = trial.shaft_rad.copy()
    shaft[:, ML] += angle_rad
    return replace(trial, shaft_rad=shaft)


def in_the_air(trial: Trial) -> FloatArray:
    """1 where the foot of ML bears nothing."""
    return np.asarray(np.nan_to_num(trial.force_n[:, ML, 2]) < 0.5, dtype=np.float64)


def hunting(trial: Trial, amplitude_rad: float = 0.03, hz: float = 9.0) -> Trial:
    return swung(trial, amplitude_rad * in_the_air(trial) * np.sin(2 * np.pi * hz * trial.time_s))


WALKS = [
    walk(gait, 0.2, 10.0, [LAG], steer=0.05 * k, noise_seed=k)
    for k, gait in enumerate(["tripod", "metachronal", "tripod", "metachronal", "tripod"])
]


@pytest.mark.parametrize("hz", [6.0, 12.0, 25.0])
def test_a_joint_that_hunts_is_found_with_how_often_and_how_far(hz: float) -> None:
    (one,) = hunting_of([hunting(trial, 0.03, hz) for trial in WALKS[:2]], WALKS[2:])
    assert one.joint == "ML"
    assert one.frequency_hz == pytest.approx(hz, rel=0.05)
    assert one.amplitude_rad == pytest.approx(0.03, rel=0.15)
    assert one.usual_rad == 0.0
    share = np.mean([in_the_air(trial).mean() for trial in WALKS[:2]])
    assert one.share == pytest.approx(share, abs=0.06)
    assert one.chance < 5e-3
    assert one.words.startswith("ML hunts ")
    assert one.words.endswith("no reference does")


def test_references_that_hunt_as_much_make_it_usual() -> None:
    known = [hunting(trial, 0.02) for trial in WALKS[2:]]
    assert hunting_of([hunting(WALKS[0], 0.03)], known) == ()
    (more,) = hunting_of([hunting(WALKS[0], 0.06)], known)
    assert more.usual_rad == pytest.approx(0.02, rel=0.15)
    assert "references by 0.02 rad" in more.words


def test_two_references_say_too_little_of_how_a_healthy_machine_hunts() -> None:
    assert hunting_of([hunting(WALKS[0])], WALKS[2:]) != ()
    assert hunting_of([hunting(WALKS[0])], WALKS[3:]) == ()


@pytest.mark.parametrize("every", [None, 6])
def test_readings_that_would_not_show_it_say_nothing(every: int | None) -> None:
    """A reference without shafts, or with a reading every sixth frame, is none; so is such a trial."""

    def blind(trial: Trial) -> Trial:
        shaft = np.full_like(trial.shaft_rad, np.nan)
        if every is not None:
            shaft[::every] = trial.shaft_rad[::every]
        return replace(trial, shaft_rad=shaft)

    seen = hunting(WALKS[0])
    assert hunting_of([seen], [blind(WALKS[2]), *WALKS[3:]]) == ()
    assert hunting_of([seen, blind(WALKS[1]), blind(WALKS[1])], WALKS[2:]) != ()


def test_hunting_in_bursts_lasts_as_long_as_its_bursts() -> None:
    trial = WALKS[0]
    burst = np.mod(trial.time_s, 1.2) < 0.7
    (one,) = hunting_of(
        [swung(trial, np.asarray(0.03 * burst * np.sin(2 * np.pi * 15.0 * trial.time_s)))],
        WALKS[2:],
    )
    assert one.share == pytest.approx(0.7 / 1.2, abs=0.06)


def missed(trial: Trial) -> FloatArray:
    """A shaft that stands for a fifth of a second, now and then, and catches up."""
    rng, out = np.random.default_rng(5), np.zeros(len(trial.time_s))
    for at in rng.uniform(0.0, 9.0, 20):
        out -= 0.08 * ((trial.time_s > at) & (trial.time_s < at + 0.2))
    return out


def rings(trial: Trial) -> FloatArray:
    """A leg that rings each time it touches down."""
    down = np.flatnonzero(np.diff(in_the_air(trial)) < 0.0)
    out = np.zeros(len(trial.time_s))
    for at in down:
        since = trial.time_s - trial.time_s[at]
        out += np.where(since > 0.0, 0.03 * np.exp(-since / 0.15) * np.sin(126.0 * since), 0.0)
    return out


@pytest.mark.parametrize(
    "moves",
    [
        lambda trial: np.zeros(len(trial.time_s)),
        lambda trial: 0.03 * np.random.default_rng(1).standard_normal(len(trial.time_s)),
        missed,
        lambda trial: 0.03 * np.sin(2 * np.pi * 2.0 * trial.time_s),
        lambda trial: 0.002 * np.sin(2 * np.pi * 9.0 * trial.time_s),
        lambda trial: 0.03 * (np.abs(trial.time_s - 5.0) < 0.3) * np.sin(60.0 * trial.time_s),
        rings,
    ],
    ids=["none", "noise", "missed steps", "slow", "small", "a blow", "ringing"],
)
def test_what_does_not_go_on_evenly_does_not_hunt(moves: object) -> None:
    assert callable(moves)
    assert hunting_of([swung(trial, moves(trial)) for trial in WALKS[:2]], WALKS[2:]) == ()


def test_what_hunts_does_not_count_meanwhile_nor_does_its_foot() -> None:
    trials = [hunting(trial) for trial in WALKS[:2]]
    parts = whole_parts(simulator(), trials)
    channels = simulator().channels
    found = hunting_of(trials, WALKS[2:])
    for before, part in zip(
        parts, without_hunting(channels, {"shaft_error"}, trials, parts, found), strict=True
    ):
        for i, channel in enumerate(channels):
            hidden = before.observation.weight[:, i] - part.observation.weight[:, i]
            of_it = channel.joint == "ML" and channel.name[:5] in {"shaft", "foot_"}
            assert hidden.any() == of_it, channel.name
        air = np.interp(
            part.observation.time_s, trials[part.trial].time_s, in_the_air(trials[part.trial])
        )
        shaft = [i for i, c in enumerate(channels) if (c.name, c.joint) == ("shaft_error", "ML")]
        assert part.observation.weight[air == 1.0][:, shaft].mean() < 0.05
        assert part.observation.weight[air == 0.0][:, shaft].mean() > 0.6


def test_a_joint_that_hunts_has_one_form_of_play_to_try() -> None:
    found = (Hunting("ML", 9.0, 0.03, 0.0, 0.3, 1e-4),)
    listed = at_hunting(candidates_of(simulator()), found)
    there = [one for one in listed if one.family == ("gear_backlash", ("ML",))]
    assert [(one.effect.name, one.price, one.hunts) for one in there] == [(IN_LOOP, 0.0, found[0])]
    elsewhere = [one for one in listed if one.family == ("gear_backlash", ("HL",))]
    assert len(elsewhere) == 4
    assert not any(one.hunts for one in elsewhere)


def answer(trials: Sequence[Trial], references: Sequence[Trial]) -> Diagnosis:
    return diagnosed_among(KEPT, trials, references, (LAG,))


OTHERS = [
    walk(one.header.gait, 0.2, 10.0, [LAG], steer=0.05 * k, noise_seed=20 + k)
    for k, one in enumerate(WALKS[:4])
]


def test_a_joint_that_hunts_for_no_reason_is_a_gap_that_nothing_explains() -> None:
    """Without what a play does while the foot stands, the play is not believed."""
    d = answer([hunting(trial) for trial in OTHERS], WALKS)
    assert (d.verdict, d.stage, d.causes) == (Verdict.UNEXPLAINED, "actuation", ())
    assert d.none == 1.0
    assert "ML hunts 9 times a second" in d.sentence
    assert any(words.startswith("ML hunts") and "gears" in words for words in d.warnings)
    (said,) = diagnosis_json(d)["hunting"]
    assert said.joint == "ML"
    text = "\n".join(summary_lines(d, [Path("t.parquet")] * 9))
    assert "look for what the catalogue does not have" not in text.replace("\n", " ")
    assert answer(OTHERS, WALKS).verdict is Verdict.NO_GAP


def test_what_else_is_wrong_is_named_beside_a_joint_that_hunts_for_no_reason() -> None:
    soft = Cause("leg_stiffness", ("HR",), (0.6,))
    trials = [
        hunting(walk(one.header.gait, 0.2, 10.0, [LAG, soft], steer=0.05 * k, noise_seed=20 + k))
        for k, one in enumerate(WALKS[:4])
    ]
    d = answer(trials, WALKS)
    assert d.verdict is Verdict.UNEXPLAINED, "the hunting is still there"
    ((effect, joints, probability),) = [(c.effect, c.joints, c.probability) for c in d.causes]
    assert (effect, joints) == ("leg_stiffness", ("HR",))
    assert probability > 0.9


def test_two_joints_that_hunt_for_no_reason_end_the_search() -> None:
    def both(trial: Trial) -> Trial:
        shaft = hunting(trial).shaft_rad.copy()
        air = np.nan_to_num(trial.force_n[:, 4, 2]) < 0.5
        shaft[:, 4] += 0.03 * air * np.sin(2 * np.pi * 11.0 * trial.time_s)
        return replace(trial, shaft_rad=shaft)

    d = answer([both(trial) for trial in OTHERS], WALKS)
    assert {one.joint for one in d.hunting} == {"ML", "MR"}
    assert (d.verdict, d.causes) == (Verdict.UNEXPLAINED, ())


@pytest.mark.parametrize(
    ("reality", "form", "hunts"),
    [
        pytest.param("play_inside", "gear_backlash_in_loop", True, marks=THOROUGH),
        pytest.param("play_outside", "gear_backlash_beyond_encoder", False, marks=THOROUGH),
        pytest.param("usual", "gear_backlash", False, marks=THOROUGH),
    ],
)
def test_a_play_is_named_in_the_form_that_loop_and_encoder_give_it(
    reality: str, form: str, hunts: bool, tmp_path: Path
) -> None:
    """Physics of its own: the virtual servo has its motor, its gear and its loop."""

    def walked(name: str, seed: int, gait: str, *effect: str) -> Path:
        out = tmp_path / f"{name}{seed}.parquet"
        words = ["sim", "run", "--fast", "--reality", reality, "--gait", gait, "--seed", str(seed)]
        words += ["--frequency-hz", "0.2", "--seconds", "20", *effect, "--out", str(out)]
        assert command(words) == 0
        return out

    given = ("--effect", "gear_backlash@ML:width_rad=0.1")
    gaits = ("tripod", "metachronal")
    trials = [walked("t", 81 + k, gait, *given) for k, gait in enumerate(2 * gaits)]
    healthy = [walked("h", 91 + k, gait) for k, gait in enumerate(2 * gaits)]
    runs, whole = read_case(tuple(trials), tuple(healthy))
    others = {effect.family for effect in whole.effects} - {*KEPT, "coulomb_friction", "leg_flex"}
    lacking = Without(whole, tuple(others))
    study = commissioned_study(runs.trials, lacking, runs.references, standing=STANDING)
    d = diagnose_study(study)
    assert [(one.effect, one.joints, one.form) for one in d.causes[:1]] == [
        ("gear_backlash", ("ML",), form)
    ]
    assert d.causes[0].values[0].value == pytest.approx(0.1, rel=0.5)
    assert [one.joint for one in study.hunting] == (["ML"] if hunts else [])
