"""The grip of feet: the largest share of its load that a foot pushes sideways, in each cycle."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.constants import GRIP_LARGEST
from gap.interfaces import Cause, Drive
from gap.machines.legged.grip import (
    FEWEST,
    Windows,
    grip_of,
    in_all_windows,
    make_windows,
    with_all_grip,
)
from model.values.arrays import FloatArray
from tests.gap.predictions import LEGS
from tests.gap.walks import cause, simulator, walk

FR = LEGS.index("FR")
COULOMB = cause("coulomb_friction")


def test_a_window_is_whole_cycles_of_at_least_four_seconds() -> None:
    time_s = np.arange(0.0, 25.0, 0.04)
    for hz, cycles, count in ((0.1, 1, 2), (0.3, 2, 3), (1.0, 4, 6)):
        cycle = hz * time_s
        windows = make_windows(time_s, cycle, 60.0)
        assert windows.number == count, hz
        assert cycle[windows.starts[1:-1]] == pytest.approx(cycles * np.arange(1, count), abs=0.05)
        assert windows.starts[-1] == len(time_s)
    assert windows.least_n == 6.0


def test_without_a_gait_a_window_is_four_seconds_and_a_short_run_is_one() -> None:
    time_s = np.arange(0.0, 10.0, 0.04)
    windows = make_windows(time_s, np.full(len(time_s), np.nan), 60.0)
    assert time_s[windows.starts[:-1]] == pytest.approx([0.0, 4.0])
    short = time_s[:50]
    assert make_windows(short, 0.1 * short, 60.0).number == 1


def test_the_share_of_loaded_frames_alone_counts() -> None:
    draws = np.random.default_rng(4)
    force = draws.uniform(-3.0, 3.0, (80, 2, 3))
    force[..., 2] = draws.uniform(7.0, 20.0, (80, 2))
    force[::3, 0] = [50.0, 0.0, 5.0]  # a foot that is hardly loaded, and pushes more than it can
    force[1, 1, 0] = np.nan
    windows = Windows(np.array([0, 40, 80]), 6.0)
    grip = grip_of(windows, force)
    for first, last in ((0, 40), (40, 80)):
        for foot in (0, 1):
            rows = force[first:last, foot]
            rows = rows[(rows[:, 2] > 6.0) & np.isfinite(rows).all(axis=1)]
            share = np.quantile(np.hypot(rows[:, 0], rows[:, 1]) / rows[:, 2], GRIP_LARGEST)
            assert grip[first:last, foot] == pytest.approx(np.log(share))


def test_a_foot_without_enough_loaded_frames_has_none_in_that_window() -> None:
    force = np.tile([1.0, 0.0, 0.0], (60, 1, 1))
    force[: FEWEST - 1, 0, 2] = 10.0
    force[30 : 30 + FEWEST, 0, 2] = 10.0
    grip = grip_of(Windows(np.array([0, 30, 60]), 6.0), force)
    assert np.isnan(grip[:30]).all()
    assert grip[30:, 0] == pytest.approx(np.log(0.1))
    assert in_all_windows(grip)[:, 0] == pytest.approx(np.log(0.1))
    assert np.isnan(in_all_windows(np.full((5, 1), np.nan))).all()


@given(
    angle=st.floats(0.0, 6.28), w=st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
    mu=st.floats(0.1, 1.5), load=st.floats(0.5, 80.0), scale=st.floats(0.01, 10.0),
)  # fmt: skip
def test_all_grip_is_the_law_of_a_sliding_foot(
    angle: float, w: tuple[float, float], mu: float, load: float, scale: float
) -> None:
    """F = mu N (1 + w w') z with a unit vector z; of any force along it, with_all_grip returns F."""
    z = np.array([np.cos(angle), np.sin(angle)])
    force = mu * load * (np.eye(2) + np.outer(w, w)) @ z
    less = np.array([[[*(scale * force), load]]])
    full = with_all_grip(less, np.array([[mu]]), np.array([[w]]))
    assert full[0, 0] == pytest.approx([*force, load], rel=1e-6, abs=1e-9)


@cache
def given_grip(drive: Drive, *causes: Cause) -> FloatArray:
    """Mean grip that the simulator gives each foot, (N,)."""
    at = [k for k, channel in enumerate(simulator().channels) if channel.name == "grip"]
    predicted = simulator().predict(walk("tripod", 0.2, 12.0), causes, drive)
    return np.asarray(predicted[:, at].mean(axis=0))


@pytest.mark.parametrize("law", [(), (COULOMB,)])
@pytest.mark.parametrize("drive", list(Drive))
def test_friction_changes_it_by_its_ratio_under_every_law(
    drive: Drive, law: tuple[Cause, ...]
) -> None:
    base = given_grip(drive, *law)
    less = given_grip(drive, *law, cause("friction_level", 0.7)) - base
    assert less == pytest.approx(np.full(6, np.log(0.7)), abs=1e-6)
    one = given_grip(drive, *law, cause("foot_friction", 0.6, legs=("FR",))) - base
    assert one[FR] == pytest.approx(np.log(0.6), abs=1e-6)
    assert np.delete(one, FR) == pytest.approx(np.zeros(5), abs=1e-6)


@pytest.mark.parametrize(
    "other",
    [
        cause("leg_length", 0.003, legs=("FR",)),
        cause("payload", 0.8, 0.1, -0.1),
        cause("drag", 150.0),
        cause("force_gain", 0.85, legs=("FR",)),
        cause("force_rotation", 0.2, legs=("FR",)),
    ],
)
def test_what_is_no_friction_leaves_it(other: Cause) -> None:
    change = given_grip(Drive.COMMAND, other) - given_grip(Drive.COMMAND)
    assert change == pytest.approx(np.zeros(6), abs=0.02)


def test_a_sensor_that_reads_other_forces_reads_another_grip_there() -> None:
    change = given_grip(Drive.COMMAND, cause("force_bias", 2.0, 0.0, -2.0, legs=("FR",)))
    change = change - given_grip(Drive.COMMAND)
    assert change[FR] > 0.1
    assert np.delete(change, FR) == pytest.approx(np.zeros(5), abs=1e-6)


def test_it_is_read_of_measured_forces() -> None:
    """A walk whose feet slide under the exact law has the grip that its friction gives."""
    at = [k for k, channel in enumerate(simulator().channels) if channel.name == "grip"]
    for causes in ((COULOMB,), (COULOMB, cause("foot_friction", 0.6, legs=("FR",)))):
        trial = walk("tripod", 0.2, 12.0, causes, noise_seed=3)
        seen = simulator().observe(trial).values[:, at].mean(axis=0)
        mu = simulator().machine.contact.mu * np.where(
            np.arange(6) == FR, 0.6 ** (len(causes) - 1), 1.0
        )
        assert seen == pytest.approx(np.log(mu), abs=0.08)
