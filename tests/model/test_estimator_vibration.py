"""How the body shakes: known from forces or a gyro, assumed without them, never taken for a slow error."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from model.estimator import vibration
from model.estimator.filter import Estimator
from model.estimator.neighbourhood import neighbourhood
from model.estimator.senses import Heard
from model.estimator.settings import EstimatorSettings, record_of
from model.values.arrays import FloatArray
from model.values.estimate import FIXED, VELOCITY, EstimatorState, OdometryInputs
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, feet_at, run, simulate

SETTINGS = EstimatorSettings()
STILL = np.zeros((6, 3))
PERIOD_S = PERIOD_NS * 1e-9
SPAN = np.square(feet_at(0.0).position_m[:, :2]).sum(axis=1).mean()  # feet's squared distance, mean


def after(
    share: Callable[[float], FloatArray] | None,
    left: Callable[[float], float],
    ticks: int = 300,
    settings: EstimatorSettings = SETTINGS,
) -> EstimatorState:
    """What is remembered of forces over the weight, (N, 3), and innovations of a gyro."""
    state = replace(Estimator(CONTACT, WEIGHT_N, settings).initial(), t_ns=0)
    feet = feet_at(0.0)
    for tick in range(1, ticks + 1):
        t_ns = tick * PERIOD_NS
        forces = np.full((6, 3), np.nan) if share is None else share(t_ns * 1e-9)
        there = share is not None
        heard = Heard(forces, whole=there, total=1.0, fresh=there, use=False)
        turn = left(t_ns * 1e-9)
        known = vibration.learn(state, OdometryInputs(t_ns, feet), feet, heard, turn, settings)
        state = replace(
            state, t_ns=t_ns, vibration=known, force_ns=t_ns if there else state.force_ns,
            gyro_ns=t_ns if np.isfinite(turn) else state.gyro_ns,
        )  # fmt: skip
    return state


def found(state: EstimatorState, settings: EstimatorSettings = SETTINGS) -> FloatArray:
    feet = feet_at(0.0)
    model = neighbourhood(np.zeros(FIXED + 12), feet, CONTACT, record_of(settings, WEIGHT_N))
    assert model is not None
    return vibration.variance(state.vibration, model, feet, record_of(settings, WEIGHT_N))


def no_gyro(_t_s: float) -> float:
    return np.nan


def shaken(x: float, turn: float, hz: float) -> Callable[[float], FloatArray]:
    """Forces that shake a body along x by x [m/s] and about z by a turn [rad/s], root mean square."""

    def share(t_s: float) -> FloatArray:
        beat = 2 * np.pi * hz
        swing = np.sqrt(2) * beat * np.cos(beat * t_s) / STANDARD_GRAVITY  # acceleration over g
        forces = np.zeros((6, 3))
        forces[:, 2] = 1 / 6
        forces[:, 0] += swing * x / 6
        # a moment: each foot's share across its own lever, of a body whose mass lies as far out as its feet
        lever = feet_at(0.0).position_m[:, :2]
        aside = np.column_stack([-lever[:, 1], lever[:, 0]])
        forces[:, :2] += swing * turn * SPAN * aside / np.square(lever).sum()
        return forces

    return share


@pytest.mark.parametrize("hz", [15.0, 20.0, 25.0])
def test_forces_show_how_fast_the_body_shakes(hz: float) -> None:
    """To a factor of two: for how long each push lasts is assumed, not measured."""
    settings = replace(SETTINGS, force_white_sd=0.0)
    sd = np.sqrt(found(after(shaken(0.002, 0.012, hz), no_gyro), settings))
    beat = 2 * np.pi * hz
    ratio = beat * SETTINGS.vibration_s * np.sqrt(1 - np.cos(beat * PERIOD_S))
    assert 0.5 < ratio < 2.0
    assert sd[0] / 0.002 == pytest.approx(ratio, rel=0.1)
    assert sd[2] / 0.012 == pytest.approx(ratio, rel=0.1)
    assert sd[1] < 0.2 * sd[0]


@pytest.mark.parametrize("share", [None, shaken(0.0, 0.0, 25.0)])
def test_a_gyro_shows_the_turning_itself(share: Callable[[float], FloatArray] | None) -> None:
    draw = np.random.default_rng(1)

    def left(t_s: float) -> float:
        shake = np.sqrt(2) * 0.015 * np.sin(2 * np.pi * 25.0 * t_s + 0.3)
        return float(shake + SETTINGS.gyro_sd * draw.normal())

    variance = found(after(share, left))
    assert np.sqrt(variance[2]) == pytest.approx(0.015, rel=0.25)
    # forces that do not shake say that the body turns on the spot; a gyro alone cannot tell
    assert (variance[:2] > 0).all() == (share is None)


def test_what_lasts_is_no_vibration() -> None:
    """A gyro of the wrong sign, a slope, a leg that pushes: they change with the gait, not at once."""

    def slow(t_s: float) -> FloatArray:
        forces = np.full((6, 3), 1 / 6)
        forces[:, 0] = 0.05 + 0.02 * np.sin(2 * np.pi * 0.5 * t_s)
        return forces

    variance = found(after(slow, lambda t_s: 0.05 + 0.03 * np.sin(2 * np.pi * 0.2 * t_s)))
    assert np.sqrt(variance).max() < 5e-4


def test_the_noise_of_a_gyro_is_no_vibration() -> None:
    draw = np.random.default_rng(2)
    variance = found(after(None, lambda _: float(0.8 * SETTINGS.gyro_sd * draw.normal())))
    np.testing.assert_array_equal(variance, 0.0)


def test_the_noise_of_transducers_is_no_vibration() -> None:
    draw = np.random.default_rng(4)
    noisy = after(lambda _: SETTINGS.force_white_sd * draw.normal(size=(6, 3)), no_gyro)
    sd = np.sqrt(found(noisy))
    assert (sd[:2] < 4e-4).all()
    assert sd[2] < 1.5e-3
    doubted = replace(SETTINGS, force_white_sd=2 * SETTINGS.force_white_sd)
    np.testing.assert_array_equal(found(noisy, doubted), 0.0)


def test_a_kick_is_no_vibration() -> None:
    def kicked(t_s: float) -> FloatArray:
        forces = np.full((6, 3), 1 / 6)
        forces[2, 0] += 1.0 * (abs(t_s - 2.9) < 1e-6)
        return forces

    state = after(kicked, no_gyro)
    assert 0 < state.vibration.force_change[0] < 1.0 * SETTINGS.force_sd**2


@pytest.mark.parametrize("settings", [SETTINGS, replace(SETTINGS, adaptive=False)])
def test_without_forces_and_gyro_it_grows_with_the_slip(settings: EstimatorSettings) -> None:
    state = after(None, no_gyro, 5, settings)
    feet = feet_at(0.0)
    assumed = []
    for speed in (1.0, 2.0):
        moving = FootMotion(feet.position_m, speed * feet.velocity_m_s)
        record = record_of(replace(settings, sway=False), WEIGHT_N)
        model = neighbourhood(np.zeros(FIXED + 12), moving, CONTACT, record)
        assert model is not None
        assumed.append(vibration.variance(state.vibration, model, moving, record))
        rms = np.sqrt(np.square(model.slip_B).sum(axis=1).mean())
        assert np.sqrt(assumed[-1][2]) == pytest.approx(settings.vibration_per_slip * rms)
    assert assumed[1][2] == pytest.approx(4 * assumed[0][2])
    np.testing.assert_array_equal(assumed[0][:2], 0.0)


def test_forces_that_fall_silent_are_forgotten() -> None:
    quiet = 1.0  # seconds of forces, then none

    def share(t_s: float) -> FloatArray:
        return shaken(0.002, 0.012, 25.0)(t_s)

    state = after(share, no_gyro, round(quiet / PERIOD_S))
    assert np.isfinite(state.vibration.force).all()
    feet, silent = feet_at(0.0), Heard(np.full((6, 3), np.nan), False, np.nan, False, False)
    for tick in range(1, 80):
        t_ns = state.t_ns + PERIOD_NS
        inputs = OdometryInputs(t_ns, feet)
        known = vibration.learn(state, inputs, feet, silent, np.nan, SETTINGS)
        state = replace(state, t_ns=t_ns, vibration=known)
        assert np.isfinite(known.force).all() == (tick * PERIOD_S <= SETTINGS.stale_force_s)


def test_it_is_of_the_velocity_alone() -> None:
    """Beside the state: what the filter says of pose, velocity, forces and parameters stays."""
    inputs = list(simulate(SETTINGS, 3, 100).inputs)
    calm = replace(SETTINGS, vibration_s=0.0, vibration_per_slip=0.0)
    states, said = run(inputs)
    other_states, other = run(inputs, calm)
    assert states[-1].mean.tobytes() == other_states[-1].mean.tobytes()
    assert states[-1].covariance.tobytes() == other_states[-1].covariance.tobytes()
    more = said[-1].twist_covariance - other[-1].twist_covariance
    assert (np.diag(more) > 0).all()
    np.testing.assert_array_equal(more, np.diag(np.diag(more)))
    own = states[-1].covariance[VELOCITY, VELOCITY]
    np.testing.assert_array_equal(other[-1].twist_covariance, own)
