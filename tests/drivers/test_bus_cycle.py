"""A cycle on the wire in virtual time against the time of its bytes, and what the drivers cost."""

import statistics

import pytest

from benchmarks.bus_cycle import BAUDS, SERVO_US, driver_cpu_ms, measure_cycle, wire_limit_us

# Sheet of the bus: a sync read of 23 bytes of six servos and a sync write of four bytes each.
LIMIT_US = {1_000_000: 2680.0, 3_000_000: 893.3}
WITHIN = 0.15


@pytest.mark.parametrize("baud", BAUDS)
def test_the_limit_is_that_of_the_bytes(baud: int) -> None:
    assert wire_limit_us(6, baud) == pytest.approx(LIMIT_US[baud], rel=1e-3)


@pytest.mark.parametrize("baud", BAUDS)
def test_the_driver_adds_next_to_nothing(baud: int) -> None:
    assert measure_cycle(baud, 30, servo_us=0.0).over < WITHIN
    assert measure_cycle(baud, 30, servo_us=SERVO_US).over_servos < WITHIN


def test_with_servos_that_take_their_time_one_megabaud_is_still_within_it() -> None:
    assert measure_cycle(1_000_000, 30).over < WITHIN


def test_the_drivers_processor_time_is_measured() -> None:
    """How much it may be depends on the computer: docs/reliability.md says what it was on one."""
    took_ms = driver_cpu_ms(30)
    assert len(took_ms) == 30
    assert statistics.median(took_ms) > 0.0
