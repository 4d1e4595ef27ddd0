"""What each source of measurements is worth: how its innovations compare with the noise assumed for it.

Two things are learned from the innovations of the last seconds, source by source. Their size against what
the filter expected of them gives the noise (Mehra, doi:10.1109/TAC.1970.1099422).
How much one is like the next gives the weight: n numbers whose errors last tell no more than
n (1 - r) / (1 + r) that do not, so that their noise counts (1 + r) / (1 - r) times as much.
"""

import numpy as np

from model.compiled import compiled, in_place
from model.estimator.settings import Record
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.estimate import NEVER, SOURCES, SourceMemory

LOAD, FORCE, ABSOLUTE, GYRO, TILT = range(len(SOURCES))
NO_SOURCE = -1
# Sources below this one are judged by a model of them, whose errors are learned. Others are sensors by
# themselves, and what their innovations show beyond is the motion's (``model.estimator.health.strain``).
MODELLED = ABSOLUTE
AXES = 3  # of a pose; an inclinometer has two
PRIOR_S = 2.0  # that innovations are white counts as much as so many seconds of them
LONGEST_S = 0.2  # that one innovation stands for
# Standard deviations from which on an innovation counts no more than one that lies there: of what is
# learned from, which should be what passes the gates, and of what health is judged by.
LEARNED_SD, JUDGED_SD = 2.6, 5.0
EXPECTED = 0.95  # mean square of a normal number that is cut off at LEARNED_SD


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


@compiled
def places_needed(legs: int) -> int:
    """How many numbers all sources can give at once: loads, forces, a pose, a gyro, two tilts."""
    return 3 * legs + AXES + 1 + 2


@in_place
@compiled
def place_kernel(blocks: IntArray, legs: int, source: IntArray, place: IntArray) -> None:
    """Say where each of the m numbers of a stack belongs.

    Args:
        blocks: First number, source and leg (or axis) of each, (B, 3).
        legs: N.
        source: Out: of each number, -1 for none, (m,).
        place: Out: of each in the memory, (m,).
    """
    for block in range(blocks.shape[0]):
        first, kind, leg = blocks[block, 0], blocks[block, 1], blocks[block, 2]
        end = blocks[block + 1, 0] if block + 1 < blocks.shape[0] else source.size
        begin = leg
        if kind == FORCE:
            begin = legs + 2 * leg
        elif kind == ABSOLUTE:
            begin = 3 * legs + leg
        elif kind == GYRO:
            begin = 3 * legs + AXES + leg
        elif kind == TILT:
            begin = 3 * legs + AXES + 1 + leg
        for i in range(first, end):
            source[i], place[i] = kind, begin + i - first if kind != NO_SOURCE else 0


def room_for(memory: SourceMemory) -> SourceMemory:
    """Room for a memory like this one."""
    count, places = len(memory.t_ns), len(memory.last)
    empty = np.empty
    return SourceMemory(
        empty(count, np.int64), empty(count), empty(count), empty(places), empty(places),
        empty(count), empty(count), empty(count),
    )  # fmt: skip


def closed(memory: SourceMemory) -> SourceMemory:
    """The same memory, not to be written to any more."""
    for name in memory.__slots__:
        getattr(memory, name).setflags(write=False)
    return memory


@in_place
@compiled
def learn_kernel(
    source: IntArray, place: IntArray, innovation: FloatArray, expected: FloatArray,
    noise: FloatArray, t_ns: int, settings: Record, heard_before: IntArray,
    product_before: FloatArray, normal_before: FloatArray, last_before: FloatArray,
    bias_before: FloatArray, misfit_before: FloatArray, scale_before: FloatArray,
    colour_before: FloatArray, heard_ns: IntArray, product: FloatArray, normal: FloatArray,
    last: FloatArray, bias: FloatArray, misfit: FloatArray, scale: FloatArray, colour: FloatArray,
) -> None:  # fmt: skip
    """Take the innovations of a tick into account.

    Args:
        source: Of each of the m numbers, -1 for none, (m,).
        place: Of each in the memory, (m,).
        innovation: Measured less expected, (m,).
        expected: Its variance by the state's covariance alone, (m,).
        noise: Variance of the measurement by the settings, (m,).
        t_ns: Time of the tick.
        settings: Of ``record_of``: bounds and memory.
        heard_before: What was known, the arrays of ``SourceMemory`` with the next seven.
        product_before: (S,).
        normal_before: (S,).
        last_before: Of each number.
        bias_before: Of each number.
        misfit_before: (S,).
        scale_before: (S,).
        colour_before: (S,).
        heard_ns: Out: what is known now, with the next seven.
        product: Out.
        normal: Out.
        last: Out.
        bias: Out.
        misfit: Out.
        scale: Out.
        colour: Out.
    """
    setting = settings[0]
    for kind in range(heard_ns.size):
        heard_ns[kind], product[kind] = heard_before[kind], product_before[kind]
        normal[kind], misfit[kind] = normal_before[kind], misfit_before[kind]
        scale[kind], colour[kind] = scale_before[kind], colour_before[kind]
    for k in range(last.size):
        last[k], bias[k] = last_before[k], bias_before[k]
    prior = PRIOR_S / setting["learning_s"]
    for kind in range(heard_ns.size):
        size, square, ratio, pairs, again = 0, 0.0, 0.0, 0.0, 0.0
        since_s = LONGEST_S
        if heard_ns[kind] != NEVER:
            since_s = min(max((t_ns - heard_ns[kind]) * 1e-9, 0.0), LONGEST_S)
        keep = np.exp(-since_s / setting["learning_s"])
        for i in range(source.size):
            left = innovation[i]
            if source[i] != kind or not np.isfinite(left):
                continue
            sd = np.sqrt(expected[i] + scale[kind] * noise[i])
            # no farther than an innovation can be believed to lie
            now = min(max(left / sd, -LEARNED_SD), LEARNED_SD)
            # against the settings' own noise, which does not get used to what it sees
            plain = min(abs(left) / np.sqrt(expected[i] + noise[i]), JUDGED_SD)
            size += 1
            square += now * now
            ratio += plain * plain
            k = place[i]
            if np.isfinite(last[k]):
                pairs += now * last[k]
                again += now * now
            last[k] = now
            bias[k] = keep * bias[k] + (1.0 - keep) * now * sd
        if size == 0:
            continue
        heard_ns[kind] = t_ns
        calm = np.exp(-since_s / setting["health_s"])
        misfit[kind] = calm * misfit[kind] + (1.0 - calm) * ratio / size
        if kind >= MODELLED or setting["adaptive"] == 0.0:
            continue
        product[kind] = keep * product[kind] + (1.0 - keep) * pairs / size
        normal[kind] = keep * normal[kind] + (1.0 - keep) * again / size
        # the noise grows while innovations are larger than expected, and shrinks while they are smaller
        surplus = square / size - EXPECTED
        grown = scale[kind] * np.exp(since_s / setting["learning_s"] * surplus)
        scale[kind] = min(max(grown, setting["least_scale"]), setting["most_scale"])
        like = min(max(product[kind] / (normal[kind] + prior), 0.0), 0.95)
        colour[kind] = (1.0 + like) / (1.0 - like)
