"""Stamps to host time under jitter, drift, rollover and steps; sequence numbers under everything."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.ati.clock import WINDOW, DeviceClock
from drivers.ati.packets import U32
from drivers.ati.sequence import RESTART_RUN, Arrival, SequenceWatch

SECOND = 1_000_000_000
SHORTEST_NS = 2_000_000
# What is promised for a window of half a minute and delays of up to 20 ms beyond the shortest.
BOUND_NS = 1_500_000


def ticks_at(t_ns: int, first: int, drift: float) -> int:
    """The unit's stamp at a host time: its clock loses ``drift`` and shows whole ticks."""
    return (first + int(t_ns * (1 - drift) * 4096 / SECOND)) % U32


def run(
    clock: DeviceClock,
    *,
    seconds: float,
    seed: int = 0,
    drift: float = 0.0,
    first: int = 1000,
    begin_ns: int = 0,
    scale_ns: float = 5e6,
) -> list[tuple[int, int]]:
    """Feed records at 100 Hz with delays; return true sample times and stamps."""
    random = np.random.default_rng(seed)
    sent = []
    last_ns = 0
    for index in range(round(seconds * 100)):
        t_ns = begin_ns + index * 10_000_000
        beyond = min(random.exponential(scale_ns), 20e6)
        if random.random() < 0.02:
            beyond += random.uniform(0, 200e6)  # a stall of the radio
        last_ns = max(last_ns, t_ns + SHORTEST_NS + round(beyond))  # and no overtaking
        stamp = ticks_at(t_ns, first, drift)
        clock.add(stamp, 77 * SECOND + last_ns)
        sent.append((77 * SECOND + t_ns, stamp))
    return sent


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    drift=st.floats(-200e-6, 200e-6),
    first=st.sampled_from([0, 5, 2**31, U32 - 1000]),
)
def test_host_times_are_within_the_bound(seed: int, drift: float, first: int) -> None:
    clock = DeviceClock()
    sent = run(clock, seconds=40, seed=seed, drift=drift, first=first)
    for t_ns, stamp in sent[-500:]:
        mapped = clock.host_ns(stamp)
        assert mapped is not None
        assert abs(mapped - SHORTEST_NS - t_ns) < BOUND_NS
    estimate = clock.estimate()
    assert estimate is not None
    assert estimate.drift_ppm == pytest.approx(drift * 1e6, abs=60)
    assert estimate.steps == 0
    assert estimate.rollovers == (1 if first == U32 - 1000 else 0)


def test_a_long_run_tells_the_drift_to_a_few_ppm_in_bounded_memory() -> None:
    clock = DeviceClock()
    run(clock, seconds=400, seed=1, drift=30e-6)
    estimate = clock.estimate()
    assert estimate is not None
    assert estimate.drift_ppm == pytest.approx(30, abs=8)
    assert len(clock._lowest) == WINDOW


def test_drift_is_not_guessed_from_a_few_seconds() -> None:
    clock = DeviceClock()
    assert clock.estimate() is None
    assert clock.host_ns(5) is None
    run(clock, seconds=3)
    estimate = clock.estimate()
    assert estimate is not None
    assert math.isnan(estimate.drift_ppm)
    assert 0 < estimate.jitter_ns < 30e6


@pytest.mark.parametrize("step_s", [0.3, 3600.0, 4e5, -0.5, -3600.0, -4e5])
def test_a_step_of_the_units_clock_is_recognised_and_followed(step_s: float) -> None:
    clock = DeviceClock()
    run(clock, seconds=20, seed=2, first=2**31)
    moved = 2**31 + round(step_s * 4096)
    sent = run(clock, seconds=40, seed=3, first=moved, begin_ns=20 * SECOND)
    estimate = clock.estimate()
    assert estimate is not None
    assert estimate.steps == 1
    for t_ns, stamp in sent[-100:]:
        mapped = clock.host_ns(stamp)
        assert mapped is not None
        assert abs(mapped - SHORTEST_NS - t_ns) < BOUND_NS


def test_a_stall_of_the_radio_is_no_step() -> None:
    clock = DeviceClock()
    run(clock, seconds=20, seed=4)
    for index in range(150):  # one and a half seconds arrive together, late
        t_ns = 20 * SECOND + index * 10_000_000
        clock.add(ticks_at(t_ns, 1000, 0.0), 77 * SECOND + round(21.5 * SECOND))
    run(clock, seconds=5, seed=5, begin_ns=round(21.5 * SECOND))
    estimate = clock.estimate()
    assert estimate is not None
    assert estimate.steps == 0


# Sequence numbers.


@given(
    first=st.integers(0, U32 - 1),
    order=st.lists(st.integers(0, 40), min_size=1, max_size=200),
)
def test_what_is_fresh_always_goes_forward_until_a_restart(first: int, order: list[int]) -> None:
    watch = SequenceWatch()
    newest: int | None = None
    for index in order:
        arrival, _ = watch.judge((first + index) % U32)
        if arrival is Arrival.RESTART:
            newest = index
        elif arrival.fresh:
            assert newest is None or index > newest
            newest = index
        else:
            assert newest is not None
            assert index <= newest


def test_late_and_double_records_are_never_fresh_and_do_not_move_the_mark() -> None:
    watch = SequenceWatch()
    seen = [watch.judge(s) for s in (10, 12, 11, 12, 13)]
    assert [arrival for arrival, _ in seen] == [
        Arrival.NEXT, Arrival.AFTER_GAP, Arrival.LATE, Arrival.DUPLICATE, Arrival.NEXT,
    ]  # fmt: skip
    assert [missing for _, missing in seen] == [0, 1, 0, 0, 0]


def test_a_unit_switched_off_and_on_is_heard_again_at_once() -> None:
    """It had counted to 5000 and begins at 1: not fifty seconds of late records."""
    watch = SequenceWatch()
    watch.judge(5000)
    fresh = [watch.judge(s)[0].fresh for s in range(1, 20)]
    assert fresh.index(True) == RESTART_RUN - 1
    assert all(fresh[RESTART_RUN - 1 :])


def test_the_wrap_is_no_gap() -> None:
    watch = SequenceWatch()
    watch.judge(U32 - 1)
    assert watch.judge(0) == (Arrival.NEXT, 0)
