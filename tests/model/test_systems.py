"""Named systems: motions that are what they say, and that move the way such robots move."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw, Reason, solve_frames
from model.systems.disk import WEIGHT_N, disk, disk_contact, random_disk_poses
from model.systems.multipod import deflect, extrapolate_unloaded, multipod, multipod_segments
from model.systems.predict import predict
from model.systems.quadruped import quadruped
from model.systems.slither import slither
from model.systems.stairs import Steps, climb, ground_under
from model.systems.system import System, equal_contacts, even_times
from model.values.legs import FootMotion

SHORT: dict[str, Callable[[], System]] = {
    "disk": lambda: disk(cycles=1),
    "disk of 50": lambda: disk(50, cycles=1),
    "multipod": lambda: multipod(cycles=1),
    "multipod of 12": lambda: multipod(12, cycles=1),
    "quadruped": lambda: quadruped(frames=200),
    "slither": lambda: slither(cycles=1),
    "stairs": lambda: climb(cycles=2, rate_hz=50),
}
systems = pytest.mark.parametrize("build", SHORT.values(), ids=SHORT.keys())


@systems
def test_foot_velocity_is_the_derivative_of_foot_position(build: Callable[[], System]) -> None:
    system = build()
    position, velocity = system.feet.position_m, system.feet.velocity_m_s
    by_differences = (position[2:] - position[:-2]) / (2 * system.step_s)
    error = np.abs(by_differences - velocity[1:-1])
    fastest = np.abs(velocity).max()
    assert np.median(error) < 1e-3 * fastest
    assert error.max() < 0.12 * fastest  # where the acceleration jumps, at touchdown and lift-off


@systems
def test_loads_add_up_to_the_weight_and_feet_move_smoothly(build: Callable[[], System]) -> None:
    system = build()
    predicted = predict(system)
    assert predicted.solutions.valid.all()
    assert predicted.solutions.load_n.sum(axis=1) == pytest.approx(system.weight_n)
    steps = np.linalg.norm(np.diff(system.feet.position_m, axis=0), axis=2)
    fastest = np.linalg.norm(system.feet.velocity_m_s, axis=2).max()
    assert steps.max() <= 1.05 * fastest * system.step_s
    assert predicted.poses.shape == (system.frames + 1, 3)


@pytest.mark.parametrize("legs", [6, 8, 12])
def test_disks_of_equal_legs_are_symmetrical(legs: int) -> None:
    predicted = predict(disk(legs, cycles=1, spin=1.0))
    assert predicted.velocity_B[:, :2] == pytest.approx(0, abs=1e-10)
    assert predicted.poses[-1, 2] > 0.1
    load = predicted.solutions.load_n
    for group in (load[:, ::2], load[:, 1::2]):
        assert np.ptp(group, axis=1) == pytest.approx(0, abs=1e-8)


def test_a_disk_walks_ahead_but_three_legs_cannot() -> None:
    assert predict(disk(6)).poses[-1] == pytest.approx([0.31, 0, 0], abs=0.02)
    assert predict(disk(3)).poses[-1] == pytest.approx([0, 0, 0], abs=1e-6)


@pytest.mark.parametrize("legs", [3, 4, 7, 21, 42, 50])
def test_random_disk_poses_stay_in_their_sectors_and_have_answers(legs: int) -> None:
    feet = random_disk_poses(200, legs, np.random.default_rng(1))
    azimuth = np.arctan2(feet.position_m[..., 1], feet.position_m[..., 0])
    middle = 2 * np.pi * (np.arange(legs) + 0.5) / legs
    aside = np.angle(np.exp(1j * (azimuth - middle)))
    assert np.abs(aside).max() < np.pi / legs
    assert np.ptp(feet.position_m, axis=0).min() > 1e-3
    again = random_disk_poses(200, legs, np.random.default_rng(1))
    assert (again.velocity_m_s == feet.velocity_m_s).all()
    assert solve_frames(feet, disk_contact(legs), WEIGHT_N).valid.all()


@pytest.mark.parametrize("legs", [6, 8, 10, 12])
def test_multipods_walk_straight_ahead(legs: int) -> None:
    system = multipod(legs)
    predicted = predict(system)
    assert system.weight_n == legs
    assert predicted.poses[-1, 0] > 1.0
    assert abs(predicted.poses[-1, 1]) < 0.1
    assert abs(predicted.poses[-1, 2]) < 0.05
    down = predicted.solutions.contact.mean(axis=0)
    assert ((down > 0.15) & (down < 0.75)).all()  # every leg stands and every leg is lifted


def test_the_unloaded_foot_is_found_behind_a_deflected_leaf_spring() -> None:
    system = multipod(8, cycles=2)
    load = predict(system).solutions.load_n
    seen = deflect(system.feet.position_m, load, system.contact.stiffness)
    assert np.abs(seen - system.feet.position_m).max() > 1e-3
    noise = np.random.default_rng(2).normal(0, 2e-4, seen.shape)
    segments = multipod_segments(8, system.time_s)
    found = extrapolate_unloaded(seen, load > 0, segments)
    assert found == pytest.approx(system.feet.position_m, abs=1e-9)
    found = extrapolate_unloaded(seen + noise, load > 0, segments)
    assert found == pytest.approx(system.feet.position_m, abs=1e-4)


def test_a_leg_never_seen_unloaded_stays_unknown() -> None:
    system = multipod(6, cycles=1)
    loaded = np.zeros((system.frames, 6), dtype=bool)
    loaded[:, 2] = True
    found = extrapolate_unloaded(
        system.feet.position_m, loaded, multipod_segments(6, system.time_s)
    )
    assert np.isnan(found[:, 2]).all()
    assert np.isfinite(found[:, [0, 1, 3, 4, 5]]).all()
    with pytest.raises(ModelError, match="same frames and legs"):
        extrapolate_unloaded(
            system.feet.position_m[:, :5], loaded, multipod_segments(6, system.time_s)
        )


def test_a_quadruped_trots_and_its_low_pass_takes_the_edge_off() -> None:
    system = quadruped()
    predicted = predict(system)
    assert system.frames == 921
    assert predicted.poses[-1, 0] == pytest.approx(2.3, abs=0.1)
    raw = predicted.solutions.velocity_B
    smooth = predicted.velocity_B
    assert np.abs(np.diff(smooth[:, 0])).max() < np.abs(np.diff(raw[:, 0])).max()
    assert smooth.mean(axis=0) == pytest.approx(raw.mean(axis=0), abs=1e-3)
    unfiltered = predict(replace(system, low_pass=None))
    assert (unfiltered.velocity_B == raw).all()


def test_tilt_coupling_reaches_the_model() -> None:
    system = quadruped(frames=200)  # it tilts from foot to foot
    with_it = predict(system, tilt_coupling=True).velocity_B
    assert np.abs(with_it - predict(system).velocity_B).max() > 1e-3


@pytest.mark.parametrize("law", list(FrictionLaw))
def test_stairs_raise_the_body_by_their_height(law: FrictionLaw) -> None:
    steps = Steps(np.array([0.5, 0.7]), np.array([0.0, 0.02, 0.05]))
    system = climb(steps, cycles=18, rate_hz=25, law=law)
    predicted = predict(system, law=law)
    met = [
        ground_under(pose, feet, steps)
        for pose, feet in zip(predicted.poses[:-1], system.feet.position_m, strict=True)
    ]
    assert system.ground_m == pytest.approx(np.array(met))
    assert predicted.poses[-1, 0] > 1.1
    height = predicted.solutions.pose[:, 2]
    cycle = 50
    risen = height[-cycle:].mean() - height[:cycle].mean()
    assert risen == pytest.approx(0.05, abs=1e-3)
    assert predicted.solutions.pose[:, 0].min() < -0.03  # nose up on the way


def test_a_walk_over_a_bump_ends_where_it_began() -> None:
    steps = Steps(np.array([0.5, 0.65]), np.array([0.0, 0.03, 0.0]))
    height = predict(climb(steps, cycles=18, rate_hz=25)).solutions.pose[:, 2]
    assert height.max() - height[0] > 0.01
    assert height[-50:].mean() == pytest.approx(height[:50].mean(), abs=1e-3)


def test_ground_under_points() -> None:
    steps = Steps(np.array([0.0, 1.0]), np.array([0.1, 0.2, 0.5]))
    points = np.array([[-1.0, 5.0, 0.0], [0.0, -3.0, 0.0], [0.99, 0.0, 0.0], [7.0, 0.0, 0.0]])
    assert ground_under(np.zeros(3), points, steps) == pytest.approx([0.1, 0.2, 0.2, 0.5])
    turned = np.array([0.5, 0.0, np.pi / 2])  # the body's left is the world's back
    assert ground_under(turned, points, steps) == pytest.approx([0.1, 0.5, 0.2, 0.2])


@pytest.mark.parametrize("contacts", [8, 16])
@pytest.mark.parametrize("law", list(FrictionLaw))
def test_a_slithering_body_moves_along_itself(contacts: int, law: FrictionLaw) -> None:
    predicted = predict(slither(contacts, cycles=2), law=law)
    assert predicted.poses[-1, 0] > 0.2
    assert abs(predicted.poses[-1, 1]) < 0.02
    assert (predicted.velocity_B[:, 0] > 0).all()


def test_without_more_grip_across_than_along_it_gets_nowhere() -> None:
    assert predict(slither(cycles=1, across=0.0)).poses[-1] == pytest.approx([0, 0, 0], abs=1e-9)


def test_frames_without_an_answer_are_absent_and_the_body_rests() -> None:
    system = disk(cycles=1)
    position = system.feet.position_m.copy()
    position[50:60, :, 0] += 1.0  # all feet ahead of the centre of mass
    tipping = replace(system, feet=FootMotion(position, system.feet.velocity_m_s), low_pass=0.5)
    predicted = predict(tipping)
    assert (predicted.solutions.reason[50:60] == Reason.TIPS).all()
    assert np.isnan(predicted.velocity_B[50:60]).all()
    assert np.isfinite(predicted.velocity_B[60:]).all()
    assert (predicted.poses[50:61] == predicted.poses[50]).all()


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: disk(2), "3 to 50 legs, not 2"),
        (lambda: disk(51), "3 to 50 legs, not 51"),
        (lambda: disk(spin=1.5), "share from 0 to 1"),
        (lambda: disk(cycles=float("nan")), "must be positive"),
        (lambda: random_disk_poses(0, 6, np.random.default_rng()), "must be positive"),
        (lambda: multipod(7), "6, 8, 10 or 12 legs, not 7"),
        (lambda: slither(3), "at least 4 contacts"),
        (lambda: quadruped(frames=1), "at least 2 frames"),
        (lambda: Steps(np.array([0.1]), np.array([0.0])), "one height more"),
        (lambda: Steps(np.array([0.2, 0.1]), np.zeros(3)), "must grow"),
        (lambda: even_times(0.01, 100.0), "too short"),
    ],
)
def test_wrong_input_is_told_in_one_line(build: Callable[[], object], words: str) -> None:
    with pytest.raises(ModelError, match=words) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_a_system_refuses_arrays_that_do_not_fit() -> None:
    system = disk(cycles=1)
    with pytest.raises(ModelError, match="stiffness must be"):
        replace(system, contact=equal_contacts(5, 1.0, 1.0))
    with pytest.raises(ModelError, match="ground_m must be"):
        replace(system, ground_m=np.zeros(6))
    with pytest.raises(ModelError, match="evenly spaced"):
        replace(system, time_s=system.time_s**2)
    with pytest.raises(ModelError, match="feet of a system"):
        replace(system, feet=FootMotion(np.zeros((3, 6)), np.zeros((3, 6))))
