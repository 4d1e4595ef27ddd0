"""The estimator: derivatives, symmetries, consistency."""

from dataclasses import replace

import numpy as np
import pytest

from model.errors import ModelError
from model.estimator import measurements as measure
from model.estimator import process
from model.estimator.filter import Estimator
from model.estimator.history import EstimatorMemory, LateSample, advance, use_late
from model.estimator.kalman import MeasurementStack, mended, sound
from model.estimator.neighbourhood import Neighbourhood, neighbourhood
from model.estimator.process import ProcessStep
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.smoother import smooth
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.estimate import (
    FIXED,
    SCALE,
    TILT_BIAS,
    VELOCITY,
    Estimate,
    EstimatorState,
    Health,
    OdometryInputs,
)
from model.values.legs import FootForces, FootMotion
from model.values.parameters import ContactParameters
from robot.odometry.metrics import in_band, nees
from tests.model.estimator_world import (
    CERTAIN,
    CONTACT,
    PERIOD_NS,
    PLACES,
    WEIGHT_N,
    feet_at,
    friction_of,
    simulate,
    slip_of_feet,
    stiffness_of,
)

SETTINGS = EstimatorSettings()
RECORD = record_of(SETTINGS, WEIGHT_N)
MEMORY_S = 0.5
# a robot that is as its file says
EXACT = replace(SETTINGS, height_sd=0.0, com_sd=0.0, slope_sd=0.0)
KNOWN = replace(SETTINGS, parameter_sd=0.05, scale_sd=0.05)


def run(
    inputs: list[OdometryInputs],
    settings: EstimatorSettings = SETTINGS,
    contact: ContactParameters = CONTACT,
) -> tuple[list[EstimatorState], list[Estimate]]:
    estimator = Estimator(contact, WEIGHT_N, settings)
    state = estimator.initial()
    states, said = [], []
    for known in inputs:
        state, estimate = estimator.step(state, known)
        states.append(state)
        said.append(estimate)
    return states, said


def solved(
    mean: FloatArray, feet: FootMotion, law: FrictionLaw = FrictionLaw.COULOMB
) -> Neighbourhood:
    settings = replace(SETTINGS, law=law, rest_speed=0.0)
    answer = neighbourhood(mean, feet, CONTACT, record_of(settings, WEIGHT_N))
    assert answer is not None
    return answer


@pytest.mark.parametrize("law", FrictionLaw)
def test_neighbourhood_is_the_public_model_plus_sway(law: FrictionLaw) -> None:
    mean, feet = np.zeros(FIXED + 12), feet_at(1.3)
    settings = replace(SETTINGS, law=law, rest_speed=0.0, sway_step_s=0.001)
    without = record_of(replace(settings, sway=False), WEIGHT_N)
    found = neighbourhood(mean, feet, CONTACT, without)
    assert found is not None
    one = FootMotion(feet.position_m[None], feet.velocity_m_s[None])
    expected = solve_frames(one, CONTACT, WEIGHT_N, law=law)
    np.testing.assert_allclose(found.velocity_B, expected.velocity_B[0], atol=1e-9)
    np.testing.assert_allclose(found.load_n, expected.load_n[0], atol=1e-9)
    np.testing.assert_allclose(found.slip_B, expected.slip_B[0], atol=1e-9)
    with_sway = neighbourhood(mean, feet, CONTACT, record_of(settings, WEIGHT_N))
    assert with_sway is not None
    slopes = [
        solve_frames(
            FootMotion(one.position_m + h * one.velocity_m_s, one.velocity_m_s), CONTACT, WEIGHT_N
        ).pose[0]
        for h in (-1e-3, 1e-3)
    ]
    rate = (slopes[1] - slopes[0]) / 2e-3
    height = expected.pose[0, 2]
    np.testing.assert_allclose(
        with_sway.sway_B, [height * rate[0], -height * rate[1]], rtol=1e-6, atol=1e-12
    )


@pytest.mark.parametrize("law", FrictionLaw)
def test_process_jacobian_against_differences(law: FrictionLaw) -> None:
    record = record_of(replace(SETTINGS, law=law), WEIGHT_N)
    draw = np.random.default_rng(1)
    mean = 0.05 * draw.normal(size=FIXED + 12)
    mean[VELOCITY] = [0.02, 0.003, 0.3]
    feet = feet_at(0.7)

    def after(at: FloatArray) -> ProcessStep:
        return process.walking(at, CERTAIN, solved(at, feet, law), record, 0.01)

    analytic = after(mean).transition
    for i in range(len(mean)):
        step = np.zeros(len(mean))
        step[i] = 1e-3
        numeric = (after(mean + step).mean - after(mean - step).mean) / 2e-3
        # one-sided steps of 1 % inside, central ones here
        np.testing.assert_allclose(analytic[:, i], numeric, atol=3e-5, rtol=0.03)


def test_measurement_rows_against_differences() -> None:
    draw = np.random.default_rng(2)
    mean = 0.05 * draw.normal(size=FIXED + 12)
    mean[VELOCITY] = [0.03, 0.002, 0.1]
    feet = feet_at(2.0)
    share = np.column_stack([draw.normal(size=(6, 2)) * 0.05, np.full(6, 1 / 6)])
    every = np.ones(6, dtype=bool)
    absolute = OdometryInputs(0, feet, pose_W=np.array([1.0, 2.0, 0.3]))

    def measured(at: FloatArray) -> MeasurementStack:
        model = solved(at, feet)._replace(sway_B=solved(mean, feet).sway_B)
        pose = measure.pose_stack(at, absolute, SETTINGS)
        assert pose is not None
        forces = measure.feet_stack(
            measure.Belief(at, CERTAIN), share, feet, every, model, CONTACT.mu, RECORD
        )
        assert forces.rows.shape == (6 + 2 * 6 + 1, len(at))
        gyro = measure.gyro_stack(at, 0.2, SETTINGS)
        tilts = measure.tilt_stacks(at, (0.01, -0.02), model, SETTINGS)
        stack = measure.stacked([forces, gyro, *tilts, pose])
        assert stack is not None
        return stack

    rows = measured(mean).rows
    for i in range(len(mean)):
        step = np.zeros(len(mean))
        step[i] = 1e-4
        up, down = (measured(mean + sign * step).innovation for sign in (1, -1))
        np.testing.assert_allclose(rows[:, i], (down - up) / 2e-4, atol=2e-3)


def test_no_force_row_touches_the_global_pose() -> None:
    feet, mean = feet_at(0.4), np.zeros(FIXED + 12)
    model = solved(mean, feet)
    mean[VELOCITY] = [0.02, 0, 0]
    share = np.full((6, 3), 1 / 6)
    every = np.ones(6, dtype=bool)
    stack = measure.feet_stack(
        measure.Belief(mean, CERTAIN), share, feet, every, model, CONTACT.mu, RECORD
    )
    assert len(stack.rows) == 6 + 2 * 6 + 1
    assert not stack.rows[:, :3].any()


def test_what_is_stacked_of_a_foot_and_with_what_noise() -> None:
    feet, mean = feet_at(0.4), np.zeros(FIXED + 12)
    mean[VELOCITY] = [0.02, 0, 0]
    model = solved(mean, feet)
    covariance = np.diag(np.full(len(mean), 1e-6))
    covariance[SCALE, SCALE] = 0.04
    share = np.full((6, 3), 1 / 6)
    share[1], share[4, 0] = np.nan, np.nan
    usable = np.array([True, True, False, True, True, True])
    stack = measure.feet_stack(
        measure.Belief(mean, covariance), share, feet, usable, model, CONTACT.mu, RECORD
    )
    # no load of leg 1; no friction of 1 and 4 (not heard), of 2 (not usable)
    assert stack.blocks.tolist() == [
        [0, 0, 0], [1, 0, 2], [2, 0, 3], [3, 0, 4], [4, 0, 5],
        [5, 1, 0], [7, 1, 3], [9, 1, 5], [11, -1, 0],
    ]  # fmt: skip
    slip = slip_of_feet(mean[VELOCITY], feet, model.sway_B)[3]
    pull = CONTACT.mu[3] / 6
    size = np.sqrt(slip @ slip + SETTINGS.creep_speed**2)
    np.testing.assert_allclose(stack.innovation[7:9], 1 / 6 + pull * slip / size, rtol=1e-12)
    x, y, _ = feet.position_m[3]
    turned = 0.5e-6 * (2 + x * x + y * y) / size**2
    flat = SETTINGS.force_sd**2 + SETTINGS.force_share_sd**2 * 2 / 36
    bent = pull**2 * (turned**2 + 0.5 * (0.04 + 1e-6) ** 2)
    np.testing.assert_allclose(stack.variance[7:9], flat + bent, rtol=1e-12)
    known = np.full(5, SETTINGS.load_sd**2)
    np.testing.assert_allclose(stack.variance[:5], known, rtol=1e-12)
    gates = [SETTINGS.gate_load] * 5 + [SETTINGS.gate_pair] * 3 + [np.inf]
    assert stack.gates.tolist() == gates


def test_mending_makes_a_covariance_sound() -> None:
    broken = np.diag([1.0, -1e-3, 2.0])
    assert not sound(broken)
    assert sound(mended(broken))
    np.testing.assert_allclose(np.diag(mended(broken))[[0, 2]], [1.0, 2.0])


def test_legs_may_be_called_in_any_order() -> None:
    order = np.array([3, 5, 0, 2, 1, 4])
    world = simulate(SETTINGS, 4, 150)

    def shuffled(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m[order], known.feet.velocity_m_s[order])
        forces = replace(known.forces, force_n=known.forces.force_n[order])
        return replace(known, feet=feet, forces=forces)

    one = run(list(world.inputs))[1][-1]
    other = run([shuffled(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B, atol=1e-8)
    np.testing.assert_allclose(other.position_m, one.position_m, atol=1e-8)
    np.testing.assert_allclose(other.mu, one.mu[order], atol=1e-7)
    np.testing.assert_allclose(other.stiffness, one.stiffness[order], rtol=1e-7)


def test_a_mirrored_walk_gives_the_mirrored_estimate() -> None:
    world = simulate(SETTINGS, 5, 150)
    sign = np.array([1.0, -1.0, 1.0])

    def mirrored(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m * sign, known.feet.velocity_m_s * sign)
        return replace(
            known, feet=feet, forces=replace(known.forces, force_n=known.forces.force_n * sign)
        )

    one = run(list(world.inputs))[1][-1]
    other = run([mirrored(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B * [1, -1, -1], atol=1e-8)
    np.testing.assert_allclose(other.position_m, one.position_m * [1, -1], atol=1e-8)
    assert other.yaw_rad == pytest.approx(-one.yaw_rad, abs=1e-8)
    np.testing.assert_allclose(other.mu, one.mu, atol=1e-7)


def test_forces_twice_as_large_say_the_same() -> None:
    world = simulate(SETTINGS, 6, 150)

    def doubled(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        return replace(known, forces=replace(known.forces, force_n=2 * known.forces.force_n))

    one = run(list(world.inputs))[1][-1]
    other = run([doubled(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B, atol=1e-12)
    np.testing.assert_allclose(other.mu, one.mu, atol=1e-12)


def test_same_inputs_same_bits() -> None:
    world = simulate(SETTINGS, 7, 100)
    first, second = (run(list(world.inputs))[0][-1] for _ in range(2))
    assert first.mean.tobytes() == second.mean.tobytes()
    assert first.covariance.tobytes() == second.covariance.tobytes()


def test_without_absolute_poses_the_global_pose_is_never_known_better_than_at_first() -> None:
    world = simulate(SETTINGS, 8, 300)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    state.covariance[:3, :3] = np.eye(3)
    for known in world.inputs:
        state, estimate = estimator.step(state, known)
        assert np.diag(estimate.pose_covariance).min() >= 1 - 1e-9


def test_parameters_are_found() -> None:
    quiet = replace(EXACT, force_share_sd=0.03, load_sd=0.01, parameter_walk=0.001)
    world = simulate(quiet, 9, 1500)
    state = run(list(world.inputs), quiet)[0][-1]
    found = state.mean[SCALE:]
    sd = np.sqrt(np.diag(state.covariance))[SCALE:]
    mu = slice(friction_of(6).start - SCALE, friction_of(6).stop - SCALE)
    assert np.abs(found - world.parameters)[mu].max() < 0.06
    assert (np.abs(found - world.parameters)[2:] < 4 * sd[2:] + 0.01).all()
    assert np.corrcoef(found[mu], world.parameters[mu])[0, 1] > 0.9


def test_matched_world_is_consistent() -> None:
    """Tier one in small: the benchmark runs 50 worlds, and parameters known less well."""
    runs, known = 10, replace(EXACT, parameter_sd=KNOWN.parameter_sd, scale_sd=KNOWN.scale_sd)
    total = np.zeros((2, 250))
    for seed in range(runs):
        world = simulate(known, 100 + seed, 250)
        said = run(list(world.inputs), known)[1]
        velocity = np.array([e.velocity_B for e in said]) - world.velocity
        pose = np.array([[*e.position_m, e.yaw_rad] for e in said]) - world.pose
        total[0] += nees(velocity, np.array([e.twist_covariance for e in said])) / runs
        total[1] += nees(pose, np.array([e.pose_covariance for e in said])) / runs
    assert 2.0 < total[0].mean() < 4.2
    assert 1.5 < total[1].mean() < 5.0
    assert in_band(total[0], 3, runs) > 0.8


def test_a_late_sample_counts_as_if_it_had_come_in_time() -> None:
    world = simulate(SETTINGS, 10, 120)
    estimator = Estimator(CONTACT, WEIGHT_N)
    straight = delayed = EstimatorMemory(estimator.initial())
    for known, pose in zip(world.inputs, world.pose, strict=True):
        straight, _ = advance(estimator, straight, replace(known, pose_W=pose), MEMORY_S)
    waiting: list[LateSample] = []
    for i, (known, pose) in enumerate(zip(world.inputs, world.pose, strict=True)):
        delayed, _ = advance(estimator, delayed, known, MEMORY_S)
        waiting.append(LateSample(known.t_ns, pose))
        if i % 20 == 19:  # two at a time out of order, the rest in order
            waiting[0], waiting[1] = waiting[1], waiting[0]
            for sample in waiting:
                delayed, estimate = use_late(estimator, delayed, (sample,))
                assert estimate is not None
            waiting.clear()
    assert delayed.state.mean.tobytes() == straight.state.mean.tobytes()
    assert delayed.refused == 0


def test_late_samples_that_are_too_old_or_known_are_refused() -> None:
    world = simulate(SETTINGS, 11, 120)
    estimator = Estimator(CONTACT, WEIGHT_N)
    memory = EstimatorMemory(estimator.initial())
    late = [
        LateSample(known.t_ns, pose) for known, pose in zip(world.inputs, world.pose, strict=True)
    ]
    for known, sample in zip(world.inputs, late, strict=True):
        memory, _ = advance(estimator, memory, replace(known, pose_W=sample.pose_W), MEMORY_S)
    before = memory.state.mean.tobytes()
    for sample in (late[10], late[-5], replace(late[-1], t_ns=late[-1].t_ns + 1)):
        memory, estimate = use_late(estimator, memory, (sample,))
        assert estimate is None
    assert memory.refused == 3
    assert memory.state.mean.tobytes() == before


def test_an_absolute_pose_holds_the_estimate_also_across_half_a_turn() -> None:
    world = simulate(SETTINGS, 12, 200)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial(np.array([0.0, 0.0, np.pi - 0.05]))
    state.covariance[:3, :3] = np.diag([0.01, 0.01, 0.01])
    for known, pose in zip(world.inputs, world.pose, strict=True):
        yaw = (pose[2] + 2 * np.pi) % (2 * np.pi) - np.pi  # half a turn on, as a camera says it
        seen = np.array([-pose[0], -pose[1], yaw])
        state, estimate = estimator.step(state, replace(known, pose_W=seen))
    assert estimate.yaw_rad == pytest.approx(world.pose[-1, 2] + np.pi, abs=0.005)
    np.testing.assert_allclose(estimate.position_m, -world.pose[-1, :2], atol=0.003)
    assert np.sqrt(np.diag(estimate.pose_covariance)).max() < 0.005


def test_a_pose_that_stays_elsewhere_is_believed_in_the_end() -> None:
    world = simulate(SETTINGS, 12, 100)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    off = []
    for known, pose in zip(world.inputs, world.pose, strict=True):
        seen = pose + np.array([0.5, 0.0, 0.0])
        state, estimate = estimator.step(state, replace(known, pose_W=seen))
        off.append(abs(estimate.position_m[0] - seen[0]))
    assert min(off[:10]) > 0.4
    assert off[-1] < 0.1


def test_a_gyro_makes_the_yaw_rate_better_known() -> None:
    world = simulate(SETTINGS, 13, 200)
    with_gyro = [
        replace(known, yaw_rate_rad_s=float(v[2]))
        for known, v in zip(world.inputs, world.velocity, strict=True)
    ]
    one, other = run(list(world.inputs))[1][-1], run(with_gyro)[1][-1]
    assert other.twist_covariance[2, 2] < one.twist_covariance[2, 2]


def test_at_standstill_a_gyro_tells_its_bias() -> None:
    """Nothing moves, so what it reports is its bias; that walks, so its sd ends above that of a mean."""
    feet = FootMotion(feet_at(0.0).position_m, np.zeros((6, 3)))
    draw = np.random.default_rng(5)
    inputs = [
        OdometryInputs(i * PERIOD_NS, feet, yaw_rate_rad_s=0.013 + 0.002 * draw.normal())
        for i in range(500)
    ]
    said = run(inputs)[1]
    assert said[-1].holding
    assert said[-1].yaw_rad == pytest.approx(0, abs=1e-4)
    error = said[-1].gyro_bias_rad_s - 0.013
    assert abs(error) < 3 * said[-1].gyro_bias_sd < 0.001
    assert SETTINGS.gyro_sd / np.sqrt(500) < said[-1].gyro_bias_sd
    silent = run([replace(known, yaw_rate_rad_s=np.nan) for known in inputs])[1][-1]
    assert np.isnan([silent.gyro_bias_rad_s, silent.gyro_bias_sd]).all(), "no gyro, no bias"


@pytest.mark.parametrize("wrong", [-1.0, 180 / np.pi])
def test_a_gyro_of_a_wrong_sign_or_unit_is_noticed(wrong: float) -> None:
    world = simulate(SETTINGS, 14, 300)
    turning = [  # the robot of these worlds hardly turns of itself: all feet move aside
        replace(known, feet=turned(known.feet, 0.15)) for known in world.inputs
    ]
    plain = [replace(known, forces=None) for known in turning]
    rates = [estimate.velocity_B[2] for estimate in run(plain)[1]]
    assert np.abs(rates[50:]).min() > 0.05
    for sign, health in ((1.0, Health.OK), (wrong, Health.DEGRADED)):
        heard = [
            replace(known, yaw_rate_rad_s=sign * float(rate))
            for known, rate in zip(plain, rates, strict=True)
        ]
        last = run(heard)[1][-1]
        assert last.health is health, last.reason
        assert ("gyro contradicts the feet" in last.reason) is (sign != 1.0)
        assert (last.rejects > 100) is (sign != 1.0)


def turned(feet: FootMotion, rate: float) -> FootMotion:
    """Feet that turn about the body's z axis against a yaw rate [rad/s]: the body turns by it."""
    velocity = feet.velocity_m_s.copy()
    velocity[:, 0] += rate * feet.position_m[:, 1]
    velocity[:, 1] -= rate * feet.position_m[:, 0]
    return FootMotion(feet.position_m, velocity)


def tilted_walk(true: FloatArray, offset: FloatArray) -> list[OdometryInputs]:
    """Six seconds without forces, with the roll and pitch of a robot of these parameters, askew."""
    inputs = []
    for i in range(600):
        feet = feet_at(i * PERIOD_NS * 1e-9)
        lifted = feet.position_m.copy()
        lifted[:, 2] -= 0.01 * np.sin(2 * np.pi * (0.4 * i * PERIOD_NS * 1e-9 + np.arange(6) / 3))
        feet = FootMotion(lifted, feet.velocity_m_s)
        slope = solved(true, feet).pose
        roll, pitch = np.arctan(slope[[1, 0]]) + offset
        inputs.append(OdometryInputs(i * PERIOD_NS, feet, None, np.nan, float(roll), float(pitch)))
    return inputs


def test_tilt_tells_of_stiffness_and_of_how_the_imu_is_mounted() -> None:
    true = np.zeros(FIXED + 12)
    true[stiffness_of(6)] = [0.2, 0.1, 0, 0, -0.1, -0.2]
    offset = np.array([0.03, -0.02])
    states, said = run(tilted_walk(true, offset))
    errors = np.log(said[-1].stiffness / CONTACT.stiffness) - true[stiffness_of(6)]
    assert np.abs(errors - errors.mean()).max() < 0.05, (
        "what is common to all springs tilts nothing"
    )
    np.testing.assert_allclose(states[-1].mean[TILT_BIAS], offset, atol=2e-3)
    assert said[-1].health is Health.OK
    assert said[-1].rejects == 0


def test_smoothing_is_better_than_filtering_and_ends_with_it() -> None:
    # errors that last: white ones leave nothing for the future to tell
    lasting = replace(
        KNOWN, parameter_sd=0.02, scale_sd=0.02, bend=0.0, speed_per_slip=0.0, turn_per_slip=0.0,
        bias_speed_per_slip=0.3, bias_turn_per_slip=0.3, bias_time_s=0.5, height_sd=0.0,
        com_sd=0.0, slope_sd=0.0,
    )  # fmt: skip
    error = np.zeros(2)
    for seed in range(14, 19):
        world = simulate(lasting, seed, 300)
        states = run(list(world.inputs), lasting)[0]
        mean, covariance = smooth(states)
        np.testing.assert_array_equal(mean[-1], states[-1].mean)
        filtered = np.array([s.mean[VELOCITY] for s in states]) - world.velocity
        smoothed = mean[:, VELOCITY] - world.velocity
        error += (filtered**2).sum(), (smoothed**2).sum()
        for i, state in enumerate(states):
            assert (np.diag(covariance[i]) <= np.diag(state.covariance) + 1e-12).all()
    assert error[1] < 0.9 * error[0]


def test_predicted_forces_carry_the_weight_with_and_without_a_sensor() -> None:
    world = simulate(SETTINGS, 16, 60)
    mute = [replace(known, forces=None) for known in world.inputs]
    for inputs in (list(world.inputs), mute):
        said = run(inputs)[1][-1]
        assert said.force_B[:, 2].sum() == pytest.approx(WEIGHT_N)
        assert said.load_share.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(said.force_B[:, :2].sum(axis=0), 0, atol=1e-6)
        for k in np.flatnonzero(said.load_share > 0):
            assert sound(said.force_covariance[k])


@pytest.mark.parametrize(
    "make",
    [
        lambda: EstimatorSettings(force_sd=0.0),
        lambda: EstimatorSettings(lag_s=-1.0),
        lambda: EstimatorSettings(pose_sd=float("nan")),
        lambda: EstimatorSettings(load_on=0.01, load_off=0.05),
        lambda: Estimator(CONTACT, 0.0),
        lambda: Estimator(CONTACT, WEIGHT_N).step(
            Estimator(CONTACT, WEIGHT_N).initial(),
            OdometryInputs(0, FootMotion(np.zeros((5, 3)), np.zeros((5, 3)))),
        ),
        lambda: smooth([]),
    ],
)
def test_mistakes_are_refused(make: object) -> None:
    assert callable(make)
    with pytest.raises(ModelError):
        make()


def test_forces_of_another_robot_are_refused() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N)
    wrong = FootForces(0, np.zeros((4, 3)), np.ones(4, dtype=bool))
    with pytest.raises(ModelError, match="forces must be"):
        estimator.step(estimator.initial(), OdometryInputs(0, feet_at(0), wrong))
    assert len(PLACES) == 6
