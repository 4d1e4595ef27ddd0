"""Many ticks in a block give what the filter makes of them one by one, in every bit."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from model.estimator.block.columns import BlockFields
from model.estimator.block.inputs import BlockInputs
from model.estimator.block.run import BlockEstimator
from model.estimator.filter import Estimator
from model.estimator.history import EstimatorMemory, advance
from model.estimator.settings import EstimatorSettings
from model.estimator.shaft_zeros import SMALL_RAD
from model.quasistatic.frames import FrictionLaw
from model.values.estimate import Estimate, Health, OdometryInputs, ZeroEvidence
from model.values.legs import FootForces, FootMotion
from model.values.parameters import ContactParameters
from record.exact_values import encode_values
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, World, simulate
from tests.soaked import soaked

SETTINGS = EstimatorSettings()
MEMORY_S = 0.15
NO_FORCES = FootForces(-1, np.full((6, 3), np.nan), np.zeros(6, dtype=bool))
Change = Callable[[int, OdometryInputs], OdometryInputs]


@cache  # not made by whoever only collects tests
def world() -> World:
    return simulate(SETTINGS, 21, 300)


def arrays(known: Sequence[OdometryInputs]) -> BlockInputs:
    forces = [one.forces or NO_FORCES for one in known]
    shafts = [one.shaft_rad_s for one in known if one.shaft_rad_s is not None]
    return BlockInputs(
        np.array([one.t_ns for one in known]),
        np.array([one.feet.position_m for one in known]),
        np.array([one.feet.velocity_m_s for one in known]),
        np.array([one.t_ns for one in forces]), np.array([one.force_n for one in forces]),
        np.array([one.valid for one in forces]), np.array(shafts) if shafts else None,
        known.__getitem__,
    )  # fmt: skip


def compared(
    known: Sequence[OdometryInputs],
    settings: EstimatorSettings = SETTINGS,
    sizes: Sequence[int] = (1, 37, 100, 23),
    contact: ContactParameters = CONTACT,
) -> tuple[list[Estimate], int, ZeroEvidence]:
    """Both ways through inputs.

    Returns:
        The estimates, how many ticks were left to the filter, and what is known of the shafts' zeros.
    """
    estimator = Estimator(contact, WEIGHT_N, settings)
    blocks = BlockEstimator(Estimator(contact, WEIGHT_N, settings), MEMORY_S)
    one = other = EstimatorMemory(estimator.initial())
    said: list[Estimate] = []
    at = left = turn = 0
    while at < len(known):
        part = known[at : at + sizes[turn % len(sizes)]]
        block = blocks.advance(other, arrays(part))
        for k, inputs in enumerate(part):
            one, estimate = advance(estimator, one, inputs, MEMORY_S)
            assert encode_values(block.estimate(k)) == encode_values(estimate), at + k
            said.append(estimate)
        for name in ("position_m", "force_age_s", "gyro_bias_sd", "holding", "mu_sd", "slipping"):
            expected = np.array([getattr(estimate, name) for estimate in said[at:]])
            np.testing.assert_array_equal(BlockFields(block).column(name), expected)
        other = block.memory(len(block))
        assert encode_values(other) == encode_values(one), at
        left += block.left
        at, turn = at + len(part), turn + 1
    return said, left, one.state.zeros


def changed(change: Change) -> list[OdometryInputs]:
    return [change(i, known) for i, known in enumerate(world().inputs)]


@cache  # its words are looked at again
def compared_as_usual(change: Change) -> tuple[list[Estimate], int, ZeroEvidence]:
    return compared(changed(change))


def same(_: int, known: OdometryInputs) -> OdometryInputs:
    return known


def forces_of(known: OdometryInputs) -> FootForces:
    assert known.forces is not None
    return known.forces


def rarely(i: int, known: OdometryInputs) -> OdometryInputs:
    """Forces of every fourth tick: the newest ones are there until others come."""
    return replace(known, forces=world().inputs[i - i % 4].forces)


def silent(i: int, known: OdometryInputs) -> OdometryInputs:
    return replace(known, forces=None) if 100 < i < 200 else known


def one_missing(i: int, known: OdometryInputs) -> OdometryInputs:
    there = np.arange(6) != 2
    return replace(known, forces=replace(forces_of(known), valid=there)) if i > 50 else known


def lifted(i: int, known: OdometryInputs) -> OdometryInputs:
    forces = forces_of(known)
    return (
        replace(known, forces=replace(forces, force_n=0.01 * forces.force_n))
        if 150 < i < 190
        else known
    )


def heavier(_: int, known: OdometryInputs) -> OdometryInputs:
    forces = forces_of(known)
    return replace(known, forces=replace(forces, force_n=1.3 * forces.force_n))


def without_encoder(i: int, known: OdometryInputs) -> OdometryInputs:
    if not 120 < i < 140:
        return known
    position, velocity = known.feet.position_m.copy(), known.feet.velocity_m_s.copy()
    position[1], velocity[1] = np.nan, np.nan
    return replace(known, feet=FootMotion(position, velocity))


def standing(i: int, known: OdometryInputs) -> OdometryInputs:
    if i < 150:
        return known
    feet, forces = world().inputs[150].feet, forces_of(world().inputs[150])
    return replace(
        known,
        feet=replace(feet, velocity_m_s=np.zeros((6, 3))),
        forces=replace(forces, t_ns=known.t_ns),
    )


def out_of_time(i: int, known: OdometryInputs) -> OdometryInputs:
    """A tick that comes twice, a clock that jumps back, and a gap."""
    shift_ns = {100: -PERIOD_NS, 150: -40 * PERIOD_NS}.get(i, 0) + (
        80 * PERIOD_NS if i > 220 else 0
    )
    t_ns = known.t_ns + shift_ns
    return replace(known, t_ns=t_ns, forces=replace(forces_of(known), t_ns=t_ns))


def contradicting(i: int, known: OdometryInputs) -> OdometryInputs:
    forces = forces_of(known)
    shifted = forces.force_n + 15.0 * np.sin(0.3 * i + np.arange(18)).reshape(6, 3)
    return replace(known, forces=replace(forces, force_n=shifted)) if i > 60 else known


def with_shafts(i: int, known: OdometryInputs) -> OdometryInputs:
    """Legs with shafts, of which one seems to have a wrong zero: its height goes with its angle."""
    forces, speed = forces_of(known), np.full(6, 0.5)
    off = np.zeros((6, 3))
    off[3, 2] = 12.0 * known.feet.velocity_m_s[3, 2] / 0.004
    return replace(known, shaft_rad_s=speed, forces=replace(forces, force_n=forces.force_n + off))


@pytest.mark.parametrize(
    ("change", "most_left"),
    [
        (same, 1), (rarely, 1), (silent, 50), (one_missing, 1), (lifted, 45), (heavier, 1),
        (without_encoder, 20), (standing, 125), (out_of_time, 6), (contradicting, 150),
        (with_shafts, 1),
    ],
)  # fmt: skip
def test_a_block_gives_what_ticks_one_by_one_give(change: Change, most_left: int) -> None:
    _, left, _ = compared_as_usual(change)
    assert left <= most_left  # what is usual is not left to the filter


def test_what_needs_words_has_the_same_words() -> None:
    """The cases above hold more than ticks that are all well."""
    heavy, _, _ = compared_as_usual(heavier)
    assert "of the robot file's weight" in heavy[-1].remark
    odd, _, _ = compared_as_usual(contradicting)
    assert {Health.OK, Health.DEGRADED} <= {estimate.health for estimate in odd}
    held, _, _ = compared_as_usual(standing)
    assert held[-1].holding
    _, _, zeros = compared_as_usual(with_shafts)
    assert np.abs(zeros.angle_rad[0]).max() > SMALL_RAD


@pytest.mark.parametrize(
    "settings",
    [
        EstimatorSettings(law=FrictionLaw.VISCOUS),
        pytest.param(EstimatorSettings(adaptive=False), marks=pytest.mark.soak),
        EstimatorSettings(sway=False, force_period_s=0.01),
    ],
    ids=["viscous", "not adaptive", "no sway, all forces"],
)
def test_with_other_settings_too(settings: EstimatorSettings) -> None:
    _, left, _ = compared(changed(rarely), settings)
    assert left <= 1


@pytest.mark.parametrize("seed", soaked(range(4), lambda seed: seed < 1))
def test_any_mixture_of_trouble_gives_the_same_bits(seed: int) -> None:
    """Trouble of all kinds begins and ends anywhere, also where a block does."""
    random = np.random.default_rng(seed)
    kinds = (rarely, one_missing, heavier, without_encoder, lifted, silent, contradicting)
    known: list[OdometryInputs] = []
    while len(known) < 300:
        change, length = kinds[random.integers(len(kinds))], int(random.integers(1, 40))
        at = len(known)
        change = same if random.random() < 0.5 else change
        known += [change(i, world().inputs[i]) for i in range(at, min(at + length, 300))]
    sizes = [int(size) for size in random.integers(1, 64, size=9)]
    compared(known, sizes=sizes)


def test_three_legs() -> None:
    few = ContactParameters(np.full(3, 2500.0), np.full(3, 0.6), np.zeros((3, 2)))
    legs = [0, 2, 4]
    known = []
    for one in world().inputs[:150]:
        feet = FootMotion(one.feet.position_m[legs], one.feet.velocity_m_s[legs])
        forces = forces_of(one)
        share = forces.force_n[legs] * (WEIGHT_N / forces.force_n[legs, 2].sum())
        heard = FootForces(one.t_ns, share, np.ones(3, dtype=bool))
        known.append(replace(one, feet=feet, forces=heard))
    nothing_left = len(known)
    assert compared(known, contact=few)[1] < nothing_left
