"""One joint unlike the others: what stands out, what does not, and how often by chance."""

import numpy as np
import pytest

from gap.interfaces import Effect, Parameter, Scope
from gap.search.candidates import Candidate
from gap.search.screen import Signature, Signatures
from gap.search.unlike import unlike_joints
from model.values.arrays import FloatArray

JOINTS = ("FL", "ML", "HL", "FR", "MR", "HR")
FRAMES = 40


def effect(name: str, numbers: int) -> Effect:
    parameters = tuple(Parameter(f"p{i}", "", 0.0, -9.0, 9.0, 1.0) for i in range(numbers))
    return Effect(name, "press", parameters, (Scope.JOINT,), "It happens.", "look at it.")


def machine(
    sizes: dict[str, FloatArray], seed: int = 0, noise: float = 1.0
) -> tuple[Signatures, FloatArray]:
    """Each joint has a channel; each effect's ``sizes``, (joints, numbers), are what joints ask for."""
    rng = np.random.default_rng(seed)
    residual = noise * rng.standard_normal((FRAMES, len(JOINTS)))
    each: list[Signature] = []
    rows: list[FloatArray] = []
    for name, asked in sizes.items():
        one = effect(name, asked.shape[1])
        for at, joint in enumerate(JOINTS):
            own = []
            for number in range(asked.shape[1]):
                change = np.zeros_like(residual)
                change[:, at] = rng.standard_normal(FRAMES)
                residual += asked[at, number] * change
                own.append(len(rows))
                rows.append(change.ravel())
            neutral = (0.0,) * len(own)
            each.append(
                Signature(Candidate(one, (joint,)), neutral, tuple(range(len(own))), tuple(own), -1)
            )
    return Signatures(tuple(each), np.array(rows, dtype=np.float32)), residual


def chance(signatures: Signatures, residual: FloatArray, name: str, joint: str) -> float:
    found = unlike_joints(signatures, residual, np.ones_like(residual), set())
    return next(o.chance for o in found if o.candidate.key == (name, (joint,)))


@pytest.mark.parametrize("numbers", [1, 3])
def test_the_joint_that_differs_is_found_with_what_it_asks_for(numbers: int) -> None:
    asked = np.zeros((6, numbers))
    asked[3] = 5.0
    signatures, residual = machine({"bias": asked, "gain": np.zeros((6, 1))})
    best, *others = unlike_joints(signatures, residual, np.ones_like(residual), set())
    assert best.candidate.key == ("bias", ("FR",))
    assert best.chance < 0.01
    assert best.values == pytest.approx((5.0,) * numbers, abs=0.7)
    assert all(one.chance > 0.05 for one in others)


def test_what_all_joints_ask_for_alike_is_nothing_at_any_of_them() -> None:
    asked = np.full((6, 1), 5.0)
    signatures, residual = machine({"bias": asked})
    assert all(
        one.chance > 0.05
        for one in unlike_joints(signatures, residual, np.ones_like(residual), set())
    )
    asked[1] = 12.0  # beyond what is common to all
    signatures, residual = machine({"bias": asked})
    assert chance(signatures, residual, "bias", "ML") < 0.01


def test_a_joint_among_joints_that_all_differ_is_not_unlike() -> None:
    asked = np.array([[3.0], [-4.0], [5.0], [6.0], [-2.0], [1.0]])
    signatures, residual = machine({"bias": asked})
    assert chance(signatures, residual, "bias", "FR") > 0.3


def test_what_is_named_takes_no_part() -> None:
    """A joint whose cause is named already no longer counts among the others, nor as unlike."""
    asked = np.zeros((6, 1))
    asked[0], asked[3] = 40.0, 5.0
    signatures, residual = machine({"bias": asked})
    named = {("bias", ("FL",))}
    found = unlike_joints(signatures, residual, np.ones_like(residual), named)
    assert ("bias", ("FL",)) not in [one.candidate.key for one in found]
    assert found[0].candidate.key == ("bias", ("FR",))
    assert found[0].chance < 0.05


def test_chances_are_among_all_that_was_compared() -> None:
    """Of machines whose joints differ by chance only, 5 % have one below 5 %."""
    least = []
    for seed in range(300):
        rng = np.random.default_rng([seed, 1])
        sizes = {name: 3.0 * rng.standard_normal((6, 1)) for name in ("bias", "gain", "lag")}
        signatures, residual = machine(sizes, seed)
        found = unlike_joints(signatures, residual, np.ones_like(residual), set())
        least.append(found[0].chance)
    assert 0.01 <= np.mean(np.array(least) < 0.05) <= 0.085  # 4 standard errors of 5 % either way


def test_three_joints_are_too_few_to_compare() -> None:
    asked = np.zeros((6, 1))
    asked[0] = 9.0
    signatures, residual = machine({"bias": asked})
    three = Signatures(signatures.each[:3], signatures.matrix)
    assert unlike_joints(three, residual, np.ones_like(residual), set()) == []


def test_joints_that_ask_for_nothing_at_all_have_no_chance_to_be_unlike() -> None:
    """A chance of 1 among many stays 1, without a warning."""
    signatures, residual = machine({"bias": np.zeros((6, 1))}, noise=0.0)
    compared = unlike_joints(signatures, residual, np.ones_like(residual), set())
    assert [one.chance for one in compared] == [1.0] * 6
