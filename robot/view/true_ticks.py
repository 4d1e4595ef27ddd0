"""Ticks of a log with forces as its robot file has them."""

from collections.abc import Iterator
from dataclasses import replace

from record.log.reader import LogContents, StampedTick
from robot.control.effect_uses import true_forces_of_log, with_true_forces


def ticks_with_true_forces(
    ticks: Iterator[StampedTick], contents: LogContents
) -> Iterator[StampedTick]:
    """Yield the ticks of a log with forces as its robot file has them."""
    first = next(ticks, None)  # the robot file comes before the first tick
    if first is None:
        return
    true_forces = true_forces_of_log(contents.config_text)
    start_ns = contents.start_ns(first.tick.t_ns)
    yield replace(first, tick=with_true_forces(first.tick, true_forces, start_ns))
    for item in ticks:
        yield replace(item, tick=with_true_forces(item.tick, true_forces, start_ns))
