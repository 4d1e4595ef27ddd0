"""What each source of measurements is worth: how its innovations compare with the noise assumed for it.

Two things are learned from the innovations of the last seconds, source by source. Their size against what
the filter expected of them gives the noise (Mehra, doi:10.1109/TAC.1970.1099422).
How much one is like the next gives the weight: n numbers whose errors last tell no more than
n (1 - r) / (1 + r) that do not, so that their noise counts (1 + r) / (1 - r) times as much.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.estimate import NEVER, SOURCES, SourceMemory

LOAD, FORCE, ABSOLUTE, GYRO, TILT = range(len(SOURCES))
NO_SOURCE = -1
# Whose errors are those of a model of them. Others are sensors' own, and what their innovations show beyond
# is the motion's (``model.estimator.health.strain``).
MODELLED = readonly(np.array([True, True, False, False, False]))
AXES = 3  # of a pose; an inclinometer has two
PRIOR_S = 2.0  # that innovations are white counts as much as so many seconds of them
LONGEST_S = 0.2  # that one innovation stands for
# Standard deviations from which on an innovation counts no more than one that lies there: of what is
# learned from, which should be what passes the gates, and of what health is judged by.
USUAL, FARTHEST = 2.6, 5.0
EXPECTED = 0.95  # mean square of a normal number that is cut off at USUAL


class NumberPlaces(NamedTuple):
    """Of m measured numbers: their source, -1 for none, and the place of each in the memory, (m,)."""

    source: IntArray
    place: IntArray


def at_start(legs: int) -> SourceMemory:
    """What is known of the sources before the first tick: what the settings say."""
    count = len(SOURCES)
    return SourceMemory(
        t_ns=readonly(np.full(count, NEVER)),
        product=readonly(np.zeros(count)),
        normal=readonly(np.zeros(count)),
        last=readonly(np.full(places_needed(legs), np.nan)),
        bias=readonly(np.zeros(places_needed(legs))),
        misfit=readonly(np.ones(count)),
        scale=readonly(np.ones(count)),
        colour=readonly(np.ones(count)),
    )


def places_needed(legs: int) -> int:
    """How many numbers all sources can give at once: loads, forces, a pose, a gyro, two tilts."""
    return 3 * legs + AXES + 1 + 2


def places(blocks: IntArray, count: int, legs: int) -> NumberPlaces:
    """Say where each of the m numbers of a stack belongs.

    Args:
        blocks: First number, source and leg (or axis) of each, (B, 3).
        count: m.
        legs: N.
    """
    begins = (0, legs, 3 * legs, 3 * legs + AXES, 3 * legs + AXES + 1)
    source, place = np.full(count, NO_SOURCE), np.zeros(count, dtype=np.int64)
    rows = blocks.tolist()
    ends = [*(row[0] for row in rows[1:]), count]
    for (first, kind, leg), end in zip(rows, ends, strict=True):
        if kind != NO_SOURCE:
            source[first:end] = kind
            own = begins[kind] + leg * (2 if kind == FORCE else 1)
            place[first:end] = np.arange(own, own + end - first)
    return NumberPlaces(source, place)


def learn(
    before: SourceMemory,
    where: NumberPlaces,
    innovation: FloatArray,
    expected: FloatArray,
    noise: FloatArray,
    t_ns: int,
    settings: EstimatorSettings,
) -> SourceMemory:
    """Take the innovations of a tick into account.

    Args:
        before: What was known.
        where: Of the m numbers.
        innovation: Measured less expected, (m,).
        expected: Its variance by the state's covariance alone, (m,).
        noise: Variance of the measurement by the settings, (m,).
        t_ns: Time of the tick.
        settings: Bounds and memory.
    """
    heard = (where.source >= 0) & np.isfinite(innovation)
    if not heard.any():
        return before
    source, place = where.source[heard], where.place[heard]
    left, own, given = innovation[heard], expected[heard], noise[heard]
    count = len(SOURCES)
    size = np.bincount(source, minlength=count)
    here = size > 0
    total = own + before.scale[source] * given
    normal = np.clip(left / np.sqrt(total), -USUAL, USUAL)

    def mean(values: FloatArray) -> FloatArray:
        summed = np.bincount(source, weights=values, minlength=count).astype(np.float64)
        each: FloatArray = summed / np.maximum(size, 1)
        return each

    since_s = np.where(before.t_ns == NEVER, LONGEST_S, (t_ns - before.t_ns) * 1e-9)
    since_s = np.where(here, np.clip(since_s, 0.0, LONGEST_S), 0.0)
    keep = np.exp(-since_s / settings.learning_s)
    last = before.last[place]
    again = np.isfinite(last)

    # against the settings' own noise, which does not get used to what it sees
    ratio = np.clip(left / np.sqrt(own + given), -FARTHEST, FARTHEST) ** 2
    calm = np.exp(-since_s / settings.health_s)
    misfit = calm * before.misfit + (1.0 - calm) * mean(ratio)

    def faded(old: FloatArray, new: FloatArray) -> FloatArray:
        return readonly(keep * old + (1.0 - keep) * np.where(here, new, 0.0))

    after_last = before.last.copy()
    after_last[place] = normal
    after_bias = before.bias.copy()
    fade = keep[source]
    # no farther than an innovation can be believed to lie
    after_bias[place] = fade * after_bias[place] + (1.0 - fade) * normal * np.sqrt(total)
    memory = replace(
        before,
        t_ns=readonly(np.where(here, t_ns, before.t_ns)),
        product=faded(before.product, mean(np.where(again, normal * np.nan_to_num(last), 0.0))),
        normal=faded(before.normal, mean(np.where(again, normal**2, 0.0))),
        last=readonly(after_last),
        bias=readonly(after_bias),
        misfit=readonly(misfit),
    )
    # the noise grows while innovations are larger than expected, and shrinks while they are smaller
    surplus = np.where(here, mean(normal**2) - EXPECTED, 0.0)
    scale = before.scale * np.exp(since_s / settings.learning_s * surplus)
    prior = PRIOR_S / settings.learning_s
    like = np.clip(memory.product / (memory.normal + prior), 0.0, 0.95)
    scale = np.clip(scale, settings.least_scale, settings.most_scale)
    return replace(
        memory,
        scale=readonly(np.where(MODELLED, scale, 1.0)),
        colour=readonly(np.where(MODELLED, (1.0 + like) / (1.0 - like), 1.0)),
    )
