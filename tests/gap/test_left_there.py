"""What a cause leaves at its own joint on held-out runs, beside what is left at other joints."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gap.constants import MOST_LEFT
from gap.coverage.coverage import unwatched_stages
from gap.diagnosis.alternatives.probability import Fit, left_of, none_of_them
from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.comparison.how_far import ChannelShrink, HowFar
from gap.diagnosis.diagnose import _roughness, diagnose
from gap.interfaces import Cause, Channel, Effect
from gap.residuals.left_there import HeldOutEnergies, left_at_joint, made_worse
from gap.search.steps import Selection
from model.effects.catalogue import CATALOGUE
from tests.gap.toy import CHANNELS, EFFECTS, Toy, toy_case, toy_references

JOINTS = ("a", "b", "c", "d")
BY_NAME = {effect.name: effect for effect in EFFECTS}


def energies(after: list[float], before: float = 10.0) -> HeldOutEnergies:
    """A force at each of four joints, and the body's speed; the first joint has the cause."""
    names, joints = ["force"] * 4 + ["speed"], [*JOINTS, ""]
    first = [before, *after[1:4], 1.0]
    signals = np.ones(len(names), dtype=bool)
    return HeldOutEnergies(names, joints, np.array(first), np.array([*after, 1.0]), signals)


def test_only_what_is_beyond_other_joints_and_a_share_of_the_change_is_left() -> None:
    assert left_at_joint(energies([1.0, 1.0, 0.8, 1.2]), "a", {"a"}, 0.1) == 0.0
    left = left_at_joint(energies([4.0, 1.0, 0.8, 1.2]), "a", {"a"}, 0.1)
    assert left == pytest.approx(np.log(4.0 / (1.2 + 0.01 * 10.0)))
    # where all joints are worse than expected on this day, this one is no different
    assert left_at_joint(energies([4.0, 4.0, 4.5, 3.5]), "a", {"a"}, 0.1) == 0.0
    # nor where one of them is, without any cause: a leg that was clamped anew
    assert left_at_joint(energies([4.0, 1.0, 5.0, 1.0]), "a", {"a"}, 0.1) == 0.0
    # a hundredth of the energy of a large cause is what its form is off by
    large = energies([40.0, 1.0, 0.8, 1.2], before=4000.0)
    assert left_at_joint(large, "a", {"a"}, 0.1) == 0.0
    assert left_at_joint(large, "a", {"a"}, 0.03) == pytest.approx(np.log(40.0 / 4.8))
    assert left_at_joint(energies([1e9, 1.0, 1.0, 1.0], 1e9), "a", {"a"}, 0.1) == MOST_LEFT


def test_nothing_is_said_where_nothing_can_be_compared() -> None:
    some = energies([4.0, 1.0, 0.8, 1.2])
    assert left_at_joint(some, "no such joint", {"a"}, 0.1) == 0.0
    assert left_at_joint(some, "a", {"a", "b", "c"}, 0.1) == 0.0, "one other joint is too few"
    broken = energies([np.nan, 1.0, 0.8, 1.2])
    assert left_at_joint(broken, "a", {"a"}, 0.1) == 0.0


def test_a_signal_of_the_joint_that_becomes_worse_counts() -> None:
    """As the foot of a leg that is called shorter, and yields by its play: it hangs lower in the air."""

    def worse(before: list[float], after: list[float], signal: bool = True) -> float:
        names, joints = ["force"] * 4 + ["foot"] * 4, [*JOINTS, *JOINTS]
        whole_before, whole_after = np.array([9.0, 1, 1, 1, *before]), np.array([1.0] * 4 + after)
        signals = np.array([True] * 4 + [signal] * 4)
        return made_worse(
            HeldOutEnergies(names, joints, whole_before, whole_after, signals), "a", {"a"}
        )

    quiet = [1.6, 1.0, 1.0, 1.0]
    assert worse(quiet, [4.2, 1.0, 1.0, 1.0]) == pytest.approx(2.6)
    assert worse(quiet, [1.5, 1.0, 1.0, 1.0]) == 0.0
    # not below what is expected, nor where another joint without a cause has as much
    assert worse([0.2, 1.0, 1.0, 1.0], [0.9, 1.0, 1.0, 1.0]) == 0.0
    assert worse(quiet, [4.2, 5.0, 1.0, 1.0]) == 0.0
    assert worse(quiet, [np.nan, 1.0, 1.0, 1.0]) == 0.0
    assert worse(quiet, [99.0, 1.0, 1.0, 1.0]) == MOST_LEFT
    # what feet trap, and what lasts, no simulator has right
    assert worse(quiet, [4.2, 1.0, 1.0, 1.0], signal=False) == 0.0


@cache
def biased() -> Diagnosis:
    return diagnose(toy_case([Cause("bias", ("a",), (0.9,))], 3), Toy(), toy_references(3))


def far(after: list[float], alone: tuple[float, ...]) -> HowFar:
    """What held-out runs show of the same four joints, in newtons that are expected."""
    rows = [
        ChannelShrink("force", joint, "N", before, np.sqrt(left), (0.0, 0.0), (0.0, 0.0), 1.0)
        for joint, before, left in zip(JOINTS, (4.0, 4.0, 1.0, 1.0), after, strict=True)
    ]
    return replace(biased().far, channels=tuple(rows), alone=alone, last=alone)


def left_of_toy(far: HowFar, causes: Sequence[Cause], effects: Mapping[str, Effect]) -> float:
    return left_of(far, causes, effects, CHANNELS)


def test_of_several_causes_each_counts_by_its_part() -> None:
    one, two = Cause("bias", ("a",), (0.5,)), Cause("bias", ("b",), (0.5,))
    whole = Cause("tether", (), (0.5,))
    after = [8.0, 1.0, 1.0, 1.0]
    left = np.log(8.0 / (1.0 + 0.01 * 16.0))
    assert left_of_toy(far(after, (1.0,)), (one,), BY_NAME) == pytest.approx(left)
    assert left_of_toy(far(after, (0.3, 0.9)), (one, two), BY_NAME) == pytest.approx(left / 4)
    assert left_of_toy(far(after, (0.5, 0.5)), (one, whole), BY_NAME) == pytest.approx(left / 2)
    # parts that are not known count alike
    assert left_of_toy(far(after, (np.nan, np.nan)), (one, two), BY_NAME) == pytest.approx(left / 2)
    assert left_of_toy(far(after, ()), (), BY_NAME) == 0.0
    some = far(after, (1.0,))
    # nothing is expected to be wrong there
    never_wrong = tuple(replace(one, floor=0.0) for one in some.channels)
    assert left_of_toy(replace(some, channels=never_wrong), (one,), BY_NAME) == 0.0
    rough = {**BY_NAME, "bias": replace(BY_NAME["bias"], rough=1.0)}
    assert left_of_toy(far(after, (1.0,)), (one,), rough) < left_of_toy(
        far(after, (1.0,)), (one,), BY_NAME
    )


def test_what_is_left_there_speaks_for_none_of_these() -> None:
    """Even where all that is open lies within what healthy machines show."""
    closed = Fit(1.0, 1.0, 1.0, 0.9, 0.0)
    assert none_of_them(closed, 1, referenced=True) < 0.01
    assert none_of_them(replace(closed, left_there=0.5), 1, referenced=True) < 0.1
    assert none_of_them(replace(closed, left_there=1.5), 1, referenced=True) > 0.5


def test_a_stage_that_nobody_measured_speaks_for_none_of_these() -> None:
    """How many does not matter; nor does it without references."""
    closed = Fit(1.0, 1.0, 1.0, 0.9, 0.0)
    one, two = (replace(closed, unwatched=count) for count in (1.0, 2.0))
    chance = none_of_them(one, 1, referenced=True)
    assert none_of_them(closed, 1, referenced=True) < chance / 2 < 0.02
    assert none_of_them(two, 1, referenced=True) == chance
    assert none_of_them(one, 1, referenced=False) == none_of_them(closed, 1, referenced=False)


def test_stages_are_unwatched_if_none_of_their_channels_was_measured() -> None:
    stages = ("shaft", "shaft", "feet", "forces", "forces")
    channels = [Channel(f"c{i}", "", stage, "") for i, stage in enumerate(stages)]
    measured = np.array([False, True, False, False, False])
    assert unwatched_stages(channels, measured) == ("feet", "forces")
    assert unwatched_stages(channels, np.ones(5, dtype=bool)) == ()


def test_a_healthy_machine_leaves_nothing_at_a_joint_of_causes() -> None:
    assert diagnose(toy_case([], 3), Toy(), toy_references(5)).fit.left_there == 0.0


def test_what_depends_on_loop_and_gears_has_many_forms() -> None:
    rough = {effect.name for effect in CATALOGUE if effect.rough == 1.0}
    compliance = {"servo_compliance", "servo_compliance_beyond_encoder"}
    forms = ("", "_in_loop", "_dragged", "_beyond_encoder")
    play = {f"gear_backlash{form}" for form in forms}
    assert rough == {"joint_friction", *play, *compliance}
    nearly = {effect.name for effect in CATALOGUE if 0.0 < effect.rough < 1.0}
    assert nearly == {"inertia_lag"}, "forces follow it only nearly"


def test_the_cause_that_closes_most_decides_whether_the_form_is_roughly_known() -> None:
    """A large misfit counts in nats by its logarithm only: a small cause may gain more than play does."""

    def rough(each: tuple[float, ...], nats: tuple[float, ...]) -> float:
        steps = [
            SimpleNamespace(
                chosen=SimpleNamespace(
                    added=SimpleNamespace(effect=SimpleNamespace(rough=one)),
                    over=SimpleNamespace(nats=gained),
                )
            )
            for one, gained in zip((0.6, 0.0), nats, strict=True)
        ]
        some = replace(biased().far, alone=each, last=each)
        return _roughness(cast(Selection, SimpleNamespace(steps=steps)), some)

    assert rough((0.5, 0.1), (10.0, 90.0)) == 0.6
    assert rough((0.1, 0.5), (90.0, 10.0)) == 0.0
    assert rough((np.nan, np.nan), (90.0, 10.0)) == 0.6, "where no gap is seen on held-out runs"
    assert not _roughness(cast(Selection, SimpleNamespace(steps=[])), biased().far)
