"""What all joints lack is one cause with a size at each, and joints are ranked by their part of the gap."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.gap_evidence import compare
from gap.diagnosis.comparison.joint_ranking import rank_joints
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive, Effect, Parameter, Scope, check_causes
from gap.machines.servo_bench.simulator import servo_bench
from gap.search.candidates import Candidate
from gap.search.contained import at_one_joint
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.options import Option, fit_option
from model.effects.causes import at_every_joint, joint_by_joint
from model.values.arrays import FloatArray
from record.trial.header import SERVO_BENCH, TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial
from tests.gap.test_selection import evidences
from tests.gap.toy import CHANNELS, EFFECTS, JOINTS, Toy, toy_case, toy_references

SIZES = {"hip": 0.05, "knee": 0.14, "ankle": 0.09}
SERVO = """[joint.{}]
controller = {{ kp_duty_per_rad = 3.0 }}
motor = {{ supply_v = 7.4, torque_constant_nm_a = 0.5, resistance_ohm = 4.0, armature_kg_m2 = 0.01 }}
"""
FILE = 'kind = "servo_bench"\n' + "".join(SERVO.format(name) for name in SIZES)
T = np.arange(400) / 50


def leg_trial(seed: int) -> Trial:
    """A run of three servos with dry friction of other sizes, and the noise of their encoders."""
    rng = np.random.default_rng(seed)
    command = {
        joint: 0.5 * np.sin(2 * np.pi * (0.3 + 0.2 * at) * T + rng.uniform(0, 6))
        for at, joint in enumerate(SIZES)
    }
    header = TrialHeader(
        SERVO_BENCH, tuple(SIZES), noise=TrialNoise(shaft_rad=0.001), robot_file="leg.toml",
        robot_text=FILE,
    )  # fmt: skip
    columns = [TableColumn("time_s", T)]
    columns += [TableColumn(f"command_{joint}_rad", own) for joint, own in command.items()]
    trial = build_trial(header, columns)
    there = [Cause("coulomb_friction", (joint,), (nm,)) for joint, nm in SIZES.items()]
    error = servo_bench([trial]).predict(trial, there, Drive.COMMAND)[:, :3]
    shaft = np.column_stack(list(command.values())) + error
    return replace(trial, shaft_rad=shaft + rng.normal(0, 0.001, shaft.shape))


def test_friction_of_all_joints_is_one_cause_with_its_size_at_each() -> None:
    trials = [leg_trial(seed) for seed in range(2)]
    simulator = servo_bench(trials)
    answer = diagnose(trials, simulator)
    first = answer.causes[0]
    assert first.effect in {"coulomb_friction_at_every_joint", "joint_friction_at_every_joint"}
    assert first.joints == ()
    sizes = {joint: own[0].value for joint, own in first.by_joint.items()}
    assert list(sizes) == ["knee", "ankle", "hip"], "the largest first"
    assert sizes == pytest.approx(SIZES, rel=0.1)
    assert first.words.startswith(f"{first.effect} (knee: nm 0.14")
    ranked = answer.where.joints
    assert {one.joint for one in ranked} == set(SIZES)
    assert ranked[-1].joint == "hip"
    assert sum(one.share for one in ranked) == pytest.approx(1.0)
    assert [one.rms for one in ranked] == sorted((one.rms for one in ranked), reverse=True)
    assert ranked[0].share > 2.0 * ranked[-1].share, "not each its own misfit's part"


class Legs(Toy):
    """A toy whose forces are of legs, which have names of their own."""

    channels = tuple(
        replace(one, joint=f"leg {one.joint}") if one.name == "force" else one for one in CHANNELS
    )


def test_a_leg_is_ranked_by_a_channel_of_its_own() -> None:
    trials = toy_case([Cause("offset", ("a",), (0.2,))], 3)
    study = make_study(trials, Legs(), toy_references(3))
    comparison = compare(study, lambda _: None)
    above = np.array([9.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])  # angles, forces, speed
    assert comparison.end_to_end is not None
    ranked = rank_joints(comparison.evidence, comparison.end_to_end, above)
    assert {one.joint: (one.channel, one.unit) for one in ranked} == {
        **dict.fromkeys("abc", ("angle", "rad")),
        **{f"leg {joint}": ("force", "N") for joint in "abc"},
    }
    assert [one.share for one in ranked[:2]] == [0.9, 0.1]
    assert all(np.isfinite(one.rms) for one in ranked), "no figure is printed as nan"


def test_a_cause_of_every_joint_is_those_of_each() -> None:
    spread = Parameter("nm", "N m", 0.0, 0.0, 2.0, 0.1)
    one = Effect("friction", "gear", (spread, replace(spread, name="nm_s")), (Scope.JOINT,), "", "")
    every = at_every_joint(one, ("a", "b"))
    assert every.scopes == (Scope.ALL,)
    assert [p.name for p in every.parameters] == ["nm@a", "nm_s@a", "nm@b", "nm_s@b"]
    values = (1.0, 2.0, 3.0, 4.0)
    assert every.by_joint(values) == {"a": (1.0, 2.0), "b": (3.0, 4.0)}
    causes = joint_by_joint(Cause(every.name, (), values), every)
    assert causes == (Cause("friction", ("a",), (1.0, 2.0)), Cause("friction", ("b",), (3.0, 4.0)))
    single = Cause("friction", ("a",), (1.0, 2.0))
    assert joint_by_joint(single, one) == (single,)


def test_a_bench_of_one_joint_has_no_effect_of_every_joint() -> None:
    alone = leg_trial(0).only(("knee",))
    assert not [one for one in servo_bench([alone]).effects if one.each]


STIFFNESS = next(one for one in EFFECTS if one.name == "stiffness")
ALL_SOFT = at_every_joint(STIFFNESS, JOINTS)
WANDER = 0.03  # of each joint's stiffness, from run to run
WITH_ALL_SOFT = (*EFFECTS, ALL_SOFT)


class EachToy(Toy):
    """A toy that can be soft at every joint; an offset of joint ``a``, which carries none, is nothing."""

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        check_causes(causes, self)
        by_name = {effect.name: effect for effect in self.effects}
        each = [one for cause in causes for one in joint_by_joint(cause, by_name[cause.effect])]
        hidden = [
            replace(one, values=(1e-12 * one.values[0],)) if one.key == ("offset", ("a",)) else one
            for one in each
        ]
        return Toy().predict(trial, hidden, drive)


@pytest.mark.parametrize(
    ("ratios", "named"),
    [
        ((1.0, 1.0, 0.75), [("stiffness", ("c",))]),
        ((0.75, 0.75, 0.75), [("stiffness_at_every_joint", ())]),
    ],
)
def test_one_joint_is_named_where_the_others_differ_as_from_day_to_day(
    ratios: Sequence[float], named: list[tuple[str, tuple[str, ...]]]
) -> None:
    """Sizes at every joint also follow the days, and gain more than the size of one."""
    true = [
        Cause("stiffness", (joint,), (ratio,)) for joint, ratio in zip(JOINTS, ratios, strict=True)
    ]
    trials, known = toy_case(true, 7, wander=WANDER), toy_references(7, wander=WANDER)
    answer = diagnose(trials, EachToy(WITH_ALL_SOFT), known)
    assert [(one.effect, one.joints) for one in answer.causes] == named
    assert answer.verdict is Verdict.EXPLAINED


def test_a_joint_at_which_a_cause_shows_nothing_tells_nothing_of_its_scatter() -> None:
    trials, known = toy_case([Cause("offset", ("b",), (0.1,))], 5), toy_references(5)
    chances = [
        found.p_cause
        for simulator in (Toy(), EachToy(WITH_ALL_SOFT))
        if (found := diagnose(trials, simulator, known).detection) is not None
    ]
    assert max(chances) < 1e-3
    assert len(chances) == 2


@pytest.mark.parametrize(
    ("catalogue", "chances", "joints"),
    [
        (WITH_ALL_SOFT, {("c",): 0.01, ("a",): 0.5, ("b",): 0.5}, ("c",)),
        (WITH_ALL_SOFT, {("c",): 0.1, ("a",): 0.5, ("b",): 0.5}, ()),  # it alone is nothing new
        (WITH_ALL_SOFT, {("c",): 0.01, ("a",): 0.01, ("b",): 0.01}, ()),  # another joint, too
        ((ALL_SOFT,), {}, ()),  # the effect of one joint was taken out of the catalogue
    ],
)
def test_at_one_joint_only_if_that_is_new_and_no_other_joint_lacks_it(
    catalogue: tuple[Effect, ...],
    chances: dict[tuple[str, ...], float],
    joints: tuple[str, ...],
) -> None:
    true = [Cause("stiffness", ("c",), (0.7,)), Cause("stiffness", ("a",), (0.9,))]
    found, _ = evidences(EachToy(catalogue), toy_case(true, 7), toy_references(7))
    nothing = unseen_score(found, fit_causes(found, ()))
    start = Cause(ALL_SOFT.name, (), (0.9, 1.0, 0.7))
    every = fit_option(found, Candidate(ALL_SOFT, ()), (start,), nothing)

    def chance(option: Option) -> float:
        return chances[option.added.joints]

    taken, p = at_one_joint(found, every, 0.02, (), chance, nothing)
    assert taken.added.joints == joints
    assert p == chances.get(joints, 0.02)


@pytest.mark.parametrize(("second", "joints"), [("stiffness", ()), ("bias", ("c",))])
def test_another_joint_with_another_cause_is_no_reason_to_name_every_joint(
    second: str, joints: tuple[str, ...]
) -> None:
    """A weaker loop at one joint looks like friction there, beside friction at another joint."""
    other = {"stiffness": 0.8, "bias": 0.5}[second]
    true = [Cause("stiffness", ("c",), (0.7,)), Cause(second, ("a",), (other,))]
    found, _ = evidences(EachToy(WITH_ALL_SOFT), toy_case(true, 7), toy_references(7))
    nothing = unseen_score(found, fit_causes(found, ()))
    start = Cause(ALL_SOFT.name, (), (0.9, 1.0, 0.7))
    every = fit_option(found, Candidate(ALL_SOFT, ()), (start,), nothing)
    taken, _ = at_one_joint(found, every, 0.02, (), lambda _: 0.001, nothing)
    assert taken.added.joints == joints
