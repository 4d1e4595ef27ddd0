"""Health, strain and remarks in a world that is the model's own, and with one thing of it wrong."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from model.estimator import health, sources
from model.estimator.filter import Estimator
from model.estimator.health import DEGRADED, MOST_STRAIN, USUAL
from model.estimator.neighbourhood import neighbourhood
from model.estimator.process import NOTHING_BESIDE, Beside, walking
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.sources import FORCE, GYRO, LOAD, TILT
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.estimate import (
    FIXED,
    SOURCES,
    VELOCITY,
    Estimate,
    EstimatorState,
    Health,
    OdometryInputs,
    SourceMemory,
)
from model.values.legs import FootForces, FootMotion
from model.values.parameters import ContactParameters
from tests.model.estimator_world import CERTAIN, CONTACT, PERIOD_NS, WEIGHT_N, feet_at
from tests.soaked import soaked

SETTINGS = EstimatorSettings()
NAMES = ("LF", "LM", "LH", "RF", "RM", "RH")
TICKS = 1200
Change = Callable[[int, FloatArray], FloatArray]


def walk(contact: ContactParameters = CONTACT) -> list[OdometryInputs]:
    """A walk on level ground whose forces balance, with a little noise: Coulomb's law and no more."""
    feet = [feet_at(i * PERIOD_NS * 1e-9) for i in range(TICKS)]
    every = FootMotion(
        np.array([f.position_m for f in feet]), np.array([f.velocity_m_s for f in feet])
    )
    solved = solve_frames(every, contact, WEIGHT_N, law=FrictionLaw.COULOMB)
    assert solved.valid.all()
    force = np.concatenate([solved.force_xy_B, solved.load_n[..., None]], axis=2)
    force += 0.003 * WEIGHT_N * np.random.default_rng(1).normal(size=force.shape)
    heard = np.ones(6, dtype=bool)
    return [
        OdometryInputs(i * PERIOD_NS, f, FootForces(i * PERIOD_NS, n, heard))
        for i, (f, n) in enumerate(zip(feet, force, strict=True))
    ]


@cache  # not made by whoever only collects tests
def clean() -> list[OdometryInputs]:
    return walk()


def run(
    change: Change, inputs: list[OdometryInputs] | None = None, yaw: float = 0.0
) -> tuple[list[Estimate], EstimatorState]:
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS, NAMES)
    state, estimates = estimator.initial(np.array([0.0, 0.0, yaw])), []
    for i, known in enumerate(clean() if inputs is None else inputs):
        assert known.forces is not None
        force = change(i, known.forces.force_n.copy())
        state, estimate = estimator.step(
            state, replace(known, forces=replace(known.forces, force_n=force))
        )
        estimates.append(estimate)
    return estimates, state


def same(_: int, force: FloatArray) -> FloatArray:
    return force


def test_in_a_clean_world_all_is_well_and_nothing_is_remarked() -> None:
    estimates, state = run(same)
    assert {estimate.health for estimate in estimates} == {Health.OK}
    assert {(estimate.reason, estimate.remark) for estimate in estimates} == {("", "")}
    np.testing.assert_array_equal(state.strain, 1.0)


@pytest.mark.parametrize(("leg", "other"), [(1, 4), pytest.param(4, 1, marks=pytest.mark.soak)])
def test_loads_that_contradict_degrade_by_the_legs_name_until_they_fit_again(
    leg: int, other: int
) -> None:
    begins, ends = 300, 600

    def change(i: int, force: FloatArray) -> FloatArray:
        if begins <= i < ends:  # half of the weight is on the other side
            force[leg, 2] += 0.5 * WEIGHT_N
            force[other, 2] -= 0.5 * WEIGHT_N
        return force

    estimates, state = run(change)
    assert all(estimate.health is Health.OK for estimate in estimates[:begins])
    faulty = estimates[ends - 1]
    assert faulty.health is Health.DEGRADED
    most, sign = re.findall(r"loads are not .* most (\w+): ([+-])", faulty.reason)[0]
    assert (most, sign) in {(NAMES[leg], "+"), (NAMES[other], "-")}
    assert estimates[begins + 250].health is Health.DEGRADED, "noticed within 2.5 s"
    # its mark fades with the memory of health
    fine_again = ends + round(SETTINGS.health_s * 1e9 / PERIOD_NS)
    assert all(estimate.health is Health.OK for estimate in estimates[fine_again:])
    assert estimates[-1].remark == ""
    np.testing.assert_array_equal(state.strain, 1.0)


def memory(misfit: FloatArray, bias: FloatArray | None = None) -> SourceMemory:
    start = sources.at_start(len(NAMES))
    return replace(start, misfit=misfit, bias=start.bias if bias is None else bias)


@given(hnp.arrays(float, len(SOURCES), elements=st.floats(0.0, 1000.0)))
def test_strain_is_1_until_a_misfit_is_unusual(misfit: FloatArray) -> None:
    asked = health.strain(memory(misfit))
    assert (asked >= 1.0).all()
    assert (asked <= MOST_STRAIN).all()
    assert asked[0] == asked[1] <= asked[2]
    feet = max(misfit[LOAD] / USUAL[LOAD], misfit[FORCE] / USUAL[FORCE])
    assert (asked[0] > 1.0) == (feet > 1.0)
    assert (asked[2] > 1.0) == (max(feet, misfit[GYRO] / USUAL[GYRO]) > 1.0)


@given(
    hnp.arrays(float, (3, 3), elements=st.floats(-1.0, 1.0)),
    hnp.arrays(float, 3, elements=st.floats(1.0, 100.0)),
)
def test_a_strained_noise_has_larger_variances_and_the_same_correlations(
    root: FloatArray, by: FloatArray
) -> None:
    mean, feet, record = np.zeros(FIXED + 12), feet_at(0.3), record_of(SETTINGS, WEIGHT_N)
    model = neighbourhood(mean, feet, CONTACT, record)
    assert model is not None
    own, noise, more = (
        walking(mean, CERTAIN, model, record, 0.01, 0, beside).noise[VELOCITY, VELOCITY]
        for beside in (
            NOTHING_BESIDE,
            Beside(root, np.ones(3), np.zeros(3)),
            Beside(root, by, np.zeros(3)),
        )
    )
    np.testing.assert_allclose(noise - own, 0.5 * root.T @ root, atol=1e-12)
    np.testing.assert_allclose(np.diag(more), by * np.diag(noise))
    sd, more_sd = np.sqrt(np.diag(noise)), np.sqrt(np.diag(more))
    np.testing.assert_allclose(more / np.outer(more_sd, more_sd), noise / np.outer(sd, sd))
    assert np.linalg.eigvalsh(more).min() > 0


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (LOAD, "loads are not those of the robot file .* most RF: -30 % of the weight"),
        (FORCE, "horizontal forces are not the model's .* most LH"),
        (GYRO, "the yaw gyro contradicts the feet"),
        (TILT, "roll and pitch contradict the legs"),
    ],
)
def test_each_source_is_named_above_its_limit_and_not_below(source: int, words: str) -> None:
    bias = np.zeros(sources.places_needed(6))
    bias[3], bias[0] = -0.3, 0.1
    bias[6 + 2 * 2 + 1], bias[6] = 0.4, -0.2
    misfit = np.ones(len(SOURCES))
    misfit[source] = DEGRADED[source]
    assert not list(health.contradictions(memory(misfit, bias), NAMES))
    misfit[source] *= 1.01
    (reason,) = health.contradictions(memory(misfit, bias), NAMES)
    assert re.match(words, reason)
    assert USUAL[source] < DEGRADED[source]


@pytest.mark.parametrize(
    ("axis", "yaw"),
    [
        pytest.param(axis, yaw, marks=() if (axis == "pitch") is (yaw < 0) else pytest.mark.soak)
        for axis in ("pitch", "roll")
        for yaw in (0.0, 1.2, -2.5)
    ],
)
def test_forces_that_lean_are_a_slope_of_so_many_degrees_uphill(axis: str, yaw: float) -> None:
    angle = np.radians(3.0)
    c, s = np.cos(angle), np.sin(angle)
    if axis == "pitch":  # the ground's push leans ahead: uphill is ahead
        turn, uphill = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), yaw
    else:
        turn, uphill = np.array([[1, 0, 0], [0, c, s], [0, -s, c]]), yaw + np.pi / 2
    estimates, _ = run(lambda _, force: force @ turn.T, clean()[:600], yaw)
    assert {estimate.health for estimate in estimates} == {Health.OK}
    slope, towards = re.findall(
        r"the ground rises by ([\d.]+) degrees towards (-?\d+) degrees of yaw", estimates[-1].remark
    )[0]
    assert float(slope) == pytest.approx(3.0, abs=0.3)
    turned = estimates[-1].yaw_rad - yaw  # the slope stays where it is, the body hardly turns
    assert abs(turned) < np.radians(5.0)
    off = (float(towards) - np.degrees(uphill) + 180.0) % 360.0 - 180.0
    assert abs(off) < 8.0


@pytest.mark.parametrize("leg", soaked([0, 2, 4], lambda leg: leg == 2))
def test_a_foot_with_a_tenth_of_the_friction_is_remarked_by_name(leg: int) -> None:
    mu = CONTACT.mu.copy()
    mu[leg] /= 10
    estimates, _ = run(same, walk(ContactParameters(CONTACT.stiffness, mu, CONTACT.anisotropy)))
    last = estimates[-1]
    assert last.health is Health.OK
    named = re.findall(r"(\w\w) has ([\d.]+) times the friction of the robot file", last.remark)
    assert [name for name, _ in named] == [NAMES[leg]]
    assert float(named[0][1]) < 0.5


@pytest.mark.parametrize("times", [0.8, 1.2])
def test_a_weight_that_is_not_the_robot_files_is_remarked(times: float) -> None:
    estimates, _ = run(lambda _, force: times * force, clean()[:300])
    assert estimates[-1].remark == f"the feet carry {times:.2f} of the robot file's weight"
    assert estimates[-1].health is Health.OK
    nearly, _ = run(lambda _, force: 1.05 * force, clean()[:300])
    assert {estimate.remark for estimate in nearly} == {""}


def test_without_forces_there_is_nothing_to_remark() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS, NAMES)
    state = estimator.initial()
    for known in clean()[:200]:
        state, estimate = estimator.step(state, replace(known, forces=None))
        assert (estimate.health, estimate.remark) == (Health.OK, "")
    assert not state.balance.any()
