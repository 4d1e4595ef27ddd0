"""What the chain remembers changes nothing: a chain that has answered much answers as a fresh one."""

import random

import numpy as np
import pytest

from gap.interfaces import Cause, Drive, Scope
from gap.machines.legged import chain
from gap.machines.legged.simulator import LeggedSimulator
from gap.machines.legged.solved import SolvedOnArrays, SolvedTraction
from model.effects.catalogue import CATALOGUE
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import SlidingFeet
from model.values.arrays import FloatArray
from tests.gap.walks import cause, machine, walk

STANDING = (cause("coulomb_friction"), cause("leg_flex", 2e-5, 3e-5), cause("pose_delay", 0.012))


def every_effect() -> list[tuple[Cause, ...]]:
    """One set of causes an effect, with those of a healthy robot; edges are within the walk's reach."""
    sets = []
    for effect in CATALOGUE:
        values = tuple(
            float(
                np.clip(p.neutral + (1 if p.upper > p.neutral else -1) * p.spread, p.lower, p.upper)
            )
            for p in effect.parameters
        )
        if effect.name in {"ground_step", "friction_patch"}:
            values = (values[0], 0.1)
        legs = ("ML",) if Scope.JOINT in effect.scopes else ()
        standing = tuple(one for one in STANDING if one.effect != effect.name)
        sets.append((*standing, Cause(effect.name, legs, values)))
    return sets


@pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)
def test_answers_do_not_depend_on_what_was_asked_before(
    drive: Drive, monkeypatch: pytest.MonkeyPatch
) -> None:
    trials = [walk(gait, 0.2, 2.5, noise_seed=4) for gait in ("tripod", "metachronal")]
    asked = [(i, one) for one in every_effect() for i in range(2)]
    busy = LeggedSimulator(machine())
    order = random.Random(5).sample(asked, len(asked))
    for i, causes in order[: len(order) // 2]:
        busy.predict(trials[i], causes, drive)
    known = [busy.predict(trials[i], causes, drive) for i, causes in asked]
    for stage in ("stands_on", "moves_feet", "moves_shafts"):  # it then sees all settings
        monkeypatch.setattr(chain, stage, lambda settings: settings)
    some = range(0, len(asked), 1 if drive is Drive.MEASURED else 3)
    for number in some:
        i, causes = asked[number]
        fresh = LeggedSimulator(machine()).predict(trials[i], causes, drive)
        assert np.array_equal(fresh, known[number], equal_nan=True), causes[-1]


def _feet(position: FloatArray) -> SlidingFeet:
    frames, count = position.shape[:2]
    limit = np.full((frames, count), 3.0)
    return SlidingFeet(position, 0.1 * position[::-1], limit, np.zeros((1, count, 2)))


def test_a_balance_is_known_again_by_its_numbers_and_nothing_else() -> None:
    solve, law = SolvedTraction(), FootLaw(True, 5e-5)
    position = np.random.default_rng(1).normal(size=(20, 4, 2))
    stiff, soft = np.zeros((1, 4, 2)), np.full((1, 4, 2), 1e-5)
    first = solve(_feet(position), law, None, 0.02, stiff)
    assert solve(_feet(position.copy()), law, None, 0.02, stiff.copy()) is first
    moved = position.copy()
    moved[-1, -1, -1] += 1e-12
    others = [
        solve(_feet(moved), law, None, 0.02, stiff),
        solve(_feet(position), FootLaw(False), None, 0.02, stiff),
        solve(_feet(position), law, None, 0.02, soft),
        solve(_feet(position), law, None, 0.01, soft),
    ]
    assert len({id(one) for one in (first, *others)}) == 5
    unknown = position.copy()
    unknown[3, 1, 0] = np.nan
    none = solve(_feet(unknown), law, None, 0.02, stiff)
    assert solve(_feet(unknown.copy()), law, None, 0.02, stiff) is none
    assert not none.valid[3]


def test_inputs_with_the_same_numbers_in_another_order_are_others() -> None:
    """Their sums of bits are the same."""
    solve, law = SolvedTraction(), FootLaw(False)
    position = np.random.default_rng(2).normal(size=(6, 4, 3))
    stiff = np.zeros((1, 4, 2))
    first = solve(_feet(position), law, None, 0.02, stiff)
    turned = solve(_feet(position[::-1].copy()), law, None, 0.02, stiff)
    assert np.array_equal(turned.velocity_B, first.velocity_B[::-1])
    assert not np.array_equal(turned.velocity_B, first.velocity_B)


def test_answers_by_identity_keep_their_arrays() -> None:
    known = SolvedOnArrays()
    made: list[int] = []

    def answer() -> int:
        made.append(len(made))
        return made[-1]

    for round_number in range(100):  # new arrays take the places of those that are gone
        assert known.of((np.full(3, 1.0 * round_number),), "rest", answer) == round_number
    same = np.ones(3)
    first = known.of((same,), "rest", answer)
    assert known.of((same,), "rest", answer) == first
    assert known.of((same,), "another", answer) != first
