"""The estimator in trouble: nothing diverges in silence; covariance grows or health says why."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from model.estimator.filter import Estimator
from model.estimator.kalman import sound
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.estimate import Estimate, EstimatorState, Health, OdometryInputs
from model.values.legs import FootForces, FootMotion
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, World, feet_at, simulate
from tests.soaked import soaked

SETTINGS = EstimatorSettings()
START_NS = 200_000_000_000
Change = Callable[[int, OdometryInputs], OdometryInputs]


@cache  # not made by whoever only collects tests
def world() -> World:
    return simulate(SETTINGS, 21, 1000)


def run(
    change: Change, ticks: int = 1000, *, since: int = 0
) -> tuple[list[Estimate], EstimatorState]:
    """Estimates, and the last state; nothing is changed before a tick, up to which all goes as usual."""
    said, states = (
        usual(since) if since else ([], [Estimator(CONTACT, WEIGHT_N, SETTINGS).initial()])
    )
    more, states = go_on(change, states[-1], range(since, ticks))
    return [*said, *more], states[-1]


def go_on(
    change: Change, state: EstimatorState, ticks: range
) -> tuple[list[Estimate], list[EstimatorState]]:
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS)
    said, states = [], [state]
    for i in ticks:
        state, estimate = estimator.step(state, change(i, world().inputs[i]))
        assert np.isfinite(state.mean).all()
        assert sound(state.covariance), i
        said.append(estimate)
        states.append(state)
    return said, states


def usual(ticks: int) -> tuple[list[Estimate], list[EstimatorState]]:
    """So many estimates of a walk without trouble, and the states before, between and after them."""
    said, states = whole()
    return said[:ticks], states[: ticks + 1]


@cache
def whole() -> tuple[list[Estimate], list[EstimatorState]]:
    return go_on(same, Estimator(CONTACT, WEIGHT_N, SETTINGS).initial(), range(1000))


def spread(estimate: Estimate) -> float:
    return float(np.trace(estimate.pose_covariance))


def same(_: int, known: OdometryInputs) -> OdometryInputs:
    return known


def base() -> list[Estimate]:
    return whole()[0]


def airborne(known: OdometryInputs) -> OdometryInputs:
    assert known.forces is not None
    return replace(known, forces=replace(known.forces, force_n=0.01 * known.forces.force_n))


def test_all_is_well_in_a_walk_without_trouble() -> None:
    assert {estimate.health for estimate in base()} == {Health.OK}


def test_forces_that_are_no_numbers_are_not_used() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        if i % 7:
            return known
        force = known.forces.force_n.copy()
        force[i % 6] = np.nan
        return replace(known, forces=replace(known.forces, force_n=force))

    said, _ = run(change)
    error = np.array([e.velocity_B for e in said]) - world().velocity
    clean = np.array([e.velocity_B for e in base()]) - world().velocity
    assert np.sqrt((error**2).mean()) < 1.2 * np.sqrt((clean**2).mean())


def test_one_transducer_missing_leaves_the_others_in_use() -> None:
    def change(_: int, known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        force = known.forces.force_n.copy()
        force[2] = np.nan
        valid = np.arange(6) != 2
        return replace(known, forces=FootForces(known.t_ns, force, valid))

    said, _ = run(change)
    assert said[-1].mu_sd[0] < said[-1].mu_sd[2]
    assert said[-1].health is Health.OK


def test_no_forces_for_five_seconds() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        return replace(known, forces=None) if 200 <= i < 700 else known

    said, _ = run(change, 711, since=200)
    assert said[240].health is Health.OK  # not stale yet
    assert said[690].health is Health.DEGRADED
    assert "no forces for" in said[690].reason
    assert spread(said[690]) > spread(base()[690])
    assert np.isfinite(said[690].force_B).all()
    assert said[710].health is Health.OK


def test_one_dead_encoder() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 300:
            return known
        position = known.feet.position_m.copy()
        position[4] = np.nan
        return replace(known, feet=FootMotion(position, known.feet.velocity_m_s))

    said, _ = run(change, since=300)
    assert said[-1].health is Health.DEGRADED
    assert "encoder" in said[-1].reason
    assert spread(said[-1]) > 4 * spread(base()[-1])
    error = np.abs(said[-1].position_m - world().pose[-1, :2])
    assert (error < 5 * np.sqrt(np.diag(said[-1].pose_covariance)[:2])).all()


def test_no_encoder_at_all_from_the_first_tick() -> None:
    nan = np.full((6, 3), np.nan)

    def change(_: int, known: OdometryInputs) -> OdometryInputs:
        return replace(known, feet=FootMotion(nan, nan))

    said, _ = run(change, 400)
    assert said[5].health is Health.DEGRADED
    assert said[-1].health is Health.LOST
    assert np.isnan(said[-1].force_B).all()


def test_repeated_forces_count_once() -> None:
    kept = {"forces": world().inputs[0].forces}

    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i % 5 == 0:
            kept["forces"] = known.forces
        return replace(known, forces=kept["forces"])

    def rare(i: int, known: OdometryInputs) -> OdometryInputs:
        return known if i % 5 == 0 else replace(known, forces=None)

    assert run(change, 200)[1].mean.tobytes() == run(rare, 200)[1].mean.tobytes()


def test_a_tick_that_comes_twice_moves_nothing() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    for known in world().inputs[:50]:
        state, _ = estimator.step(state, known)
    again, estimate = estimator.step(state, world().inputs[49])
    np.testing.assert_array_equal(again.mean, state.mean)
    assert "twice" in estimate.reason


@pytest.mark.parametrize("jump_s", [-100.0, 100.0])
def test_a_jump_of_the_clock(jump_s: float) -> None:
    jump_ns = round(jump_s * 1e9)

    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        t_ns = known.t_ns + START_NS + (jump_ns if i >= 500 else 0)
        return replace(known, t_ns=t_ns, forces=replace(known.forces, t_ns=t_ns))

    said, _ = run(change)
    assert said[500].health is Health.DEGRADED
    assert spread(said[500]) > 10 * spread(said[499])
    moved = np.abs(said[500].position_m - said[499].position_m).max()
    assert moved < 0.02
    assert said[-1].health is Health.OK  # forces are heard on the new clock
    assert np.isfinite(said[505].innovation).any()


def test_picked_up_and_put_down() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        return airborne(known) if 200 <= i < 600 else known

    said, _ = run(change, since=200)
    assert said[210].health is Health.DEGRADED
    assert "picked up" in said[210].reason
    assert said[599].health is Health.LOST
    assert spread(said[599]) > 100 * spread(said[199])
    assert np.isnan(said[300].force_B).all()
    learned = said[199].mu
    np.testing.assert_array_equal(said[599].mu, learned)  # nothing is learned in the air
    assert said[620].health is Health.LOST
    assert said[-1].health is Health.OK
    assert spread(said[-1]) > 0.9 * spread(said[599])  # where it is now is not known any better


def test_feet_that_cannot_carry_the_robot() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if not 200 <= i < 300:
            return known
        position = known.feet.position_m + np.array([1.0, 0.0, 0.0])  # all of them ahead: it tips
        return replace(known, feet=FootMotion(position, known.feet.velocity_m_s))

    said, _ = run(change, 600, since=200)
    assert "do not carry" in said[250].reason
    assert spread(said[299]) > spread(base()[299])
    assert said[-1].health is Health.OK


def test_standstill_holds_pose_and_parameters() -> None:
    feet = feet_at(0.0)
    still = FootMotion(feet.position_m, np.zeros((6, 3)))
    force = np.zeros((6, 3))
    force[:, 2] = WEIGHT_N / 6

    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 200:
            return known
        heard = FootForces(known.t_ns, force, np.ones(6, dtype=bool))
        return replace(known, feet=still, forces=heard)

    said, _ = run(change, 600, since=200)
    assert not said[215].holding
    assert said[260].holding
    np.testing.assert_array_equal(said[-1].position_m, said[260].position_m)
    np.testing.assert_array_equal(said[-1].mu, said[260].mu)
    assert spread(said[-1]) == pytest.approx(spread(said[260]))
    assert not said[-1].velocity_B.any()


def test_one_force_gone_mad_is_rejected_and_counted() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        if i != 500:
            return known
        force = known.forces.force_n.copy()
        force[1] = [90.0, -90.0, 40.0]
        return replace(known, forces=replace(known.forces, force_n=force))

    said, _ = run(change, 501, since=500)
    assert said[500].rejects > said[499].rejects
    assert np.abs(said[500].velocity_B - base()[500].velocity_B).max() < 0.02


def test_a_sensor_that_is_always_wrong_degrades_health() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        force: FloatArray = known.forces.force_n.copy()
        if i > 300:
            force[:3, 2] += 25.0
            force[3:, 2] = np.maximum(force[3:, 2] - 25.0, 0.0)
        return replace(known, forces=replace(known.forces, force_n=force))

    said, _ = run(change, since=300)
    assert said[-1].rejects > 50
    assert Health.DEGRADED in {e.health for e in said[301:]}


@pytest.mark.parametrize(
    "steps",
    [
        1_200,
        pytest.param(3_000, marks=pytest.mark.soak),
        pytest.param(20_000, marks=pytest.mark.thorough),
    ],
)
def test_covariance_stays_sound_over_many_steps(steps: int) -> None:
    """The benchmark does a million."""
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    smallest = np.inf
    for i in range(steps):
        known = world().inputs[i % 1000]
        t_ns = i * PERIOD_NS
        forces = known.forces
        if forces is not None:
            forces = replace(forces, t_ns=t_ns) if i % 1000 < 700 else None
        state, _ = estimator.step(state, replace(known, t_ns=t_ns, forces=forces))
        if i % 50 == 0:
            assert np.array_equal(state.covariance, state.covariance.T)
            smallest = min(smallest, float(np.linalg.eigvalsh(state.covariance)[0]))
    assert smallest > 0


def far_from(i: int, off_m: FloatArray) -> FloatArray:
    pose: FloatArray = world().pose[i] + np.array([*off_m, 0.0])
    return pose


@pytest.mark.parametrize(
    "off_m", soaked([1.2, 1000.0, 1e19, 1e300], lambda off_m: off_m in {1.2, 1e300})
)
def test_a_pose_metres_away_is_never_used_after_one_that_was(off_m: float) -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 100:
            return replace(known, pose_W=world().pose[i])
        if i < 600:
            return replace(known, pose_W=far_from(i, np.array([off_m, -off_m])))
        return replace(known, pose_W=world().pose[i]) if i == 900 else known

    estimates, state = run(change)
    pose = np.array([[*e.position_m, e.yaw_rad] for e in estimates])
    assert np.abs(pose - world().pose).max() < 0.1
    assert estimates[99].health is Health.OK
    assert estimates[599].health is estimates[899].health is Health.DEGRADED
    assert "500 in a row not used" in estimates[599].reason
    assert estimates[599].rejects >= estimates[99].rejects + 500
    assert estimates[900].health is Health.OK
    assert state.far_poses == 0


def test_a_pose_may_be_anywhere_again_after_the_robot_was_carried() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 100:
            return replace(known, pose_W=world().pose[i])
        if i < 200:
            return airborne(known)
        return replace(known, pose_W=far_from(i, np.array([3.0, 2.0])))

    estimates, _ = run(change, 400)
    off = estimates[-1].position_m - world().pose[399, :2]
    np.testing.assert_allclose(off, [3.0, 2.0], atol=0.1)


def test_a_pose_may_be_anywhere_again_after_a_gap_in_time() -> None:
    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 100:
            return replace(known, pose_W=world().pose[i])
        later_ns = known.t_ns + round(2e9)
        forces = known.forces and replace(known.forces, t_ns=later_ns)
        return replace(
            known, t_ns=later_ns, forces=forces, pose_W=far_from(i, np.array([3.0, 2.0]))
        )

    estimates, _ = run(change, 300)
    off = estimates[-1].position_m - world().pose[299, :2]
    np.testing.assert_allclose(off, [3.0, 2.0], atol=0.1)


def test_a_pose_may_be_anywhere_for_an_estimate_that_is_lost() -> None:
    """A tip-over: the model has no answer for so long that the estimate is lost."""

    def change(i: int, known: OdometryInputs) -> OdometryInputs:
        if i < 100:
            return replace(known, pose_W=world().pose[i])
        if i < 500:
            feet = replace(known.feet, position_m=known.feet.position_m + np.array([5.0, 0.0, 0.0]))
            pose = far_from(i, np.array([30.0, 2.0])) if i < 300 else None
            return replace(known, feet=feet, pose_W=pose)
        return replace(known, pose_W=far_from(i, np.array([3.0, 2.0])))

    estimates, _ = run(change, 700)
    assert estimates[450].health is Health.LOST
    off = estimates[-1].position_m - world().pose[699, :2]
    np.testing.assert_allclose(off, [3.0, 2.0], atol=0.1)
