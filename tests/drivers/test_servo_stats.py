"""Histograms of the bus: fixed classes, the right class, no growth."""

from drivers.dynamixel.stats import (
    JITTER_EDGES_US,
    ROUND_TRIP_EDGES_US,
    BusCounters,
    share_below,
)

US = 1000


def test_round_trips_fall_into_their_classes() -> None:
    counters = BusCounters()
    for us in (499, 500, 999, 1000, 49_999, 50_000, 900_000):
        counters.note_round_trip(us * US)
    stats = counters.snapshot()
    assert stats.round_trips == (1, 2, 1, 0, 0, 0, 0, 1, 2)
    assert stats.longest_round_trip_us == 900_000
    assert len(stats.round_trips) == len(ROUND_TRIP_EDGES_US) + 1


def test_jitter_is_the_change_of_the_interval() -> None:
    counters = BusCounters()
    for t_us in (0, 10_000, 20_000, 30_010, 40_010, 55_010):
        counters.note_begin(t_us * US)
    stats = counters.snapshot()
    assert sum(stats.jitters) == 4, "the first two reads have none"
    assert stats.jitters[0] == 3, "0, 10 and 10 us"
    assert stats.jitters[JITTER_EDGES_US.index(10_000)] == 1, "5 ms lies above the edge of 5 ms"
    assert stats.largest_jitter_us == 5000


def test_memory_does_not_grow() -> None:
    counters = BusCounters()
    for i in range(10_000):
        counters.note_begin(i * i)
        counters.note_round_trip(i * US)
    stats = counters.snapshot()
    assert (len(stats.round_trips), len(stats.jitters)) == (9, 11)
    assert sum(stats.round_trips) == 10_000


def test_a_share_is_the_edge_of_its_class() -> None:
    edges = (10, 20, 50)
    assert share_below((5, 4, 0, 1), edges, 0.5, 700) == 10
    assert share_below((5, 4, 0, 1), edges, 0.9, 700) == 20
    assert share_below((5, 4, 0, 1), edges, 0.99, 700) == 700
    assert share_below((5, 0, 0, 0), edges, 0.5, 3) == 3, "never beyond the largest"
    assert share_below((0, 0, 0, 0), edges, 0.5, 0) is None
