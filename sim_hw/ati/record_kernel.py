"""What the transducers of a force-torque unit sense, as counts, in one compiled call.

Products and sums in the order in which they are written, as numpy does it: the same bits with and without
machine code.
"""

import numpy as np

from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.values.arrays import FloatArray, IntArray


@in_place
@compiled
def sensed_counts(
    wrench: FloatArray,
    chance: FloatArray,
    noise: FloatArray,
    rating: FloatArray,
    used: IntArray,
    slots: IntArray,
    counts_per_unit: int,
    counts: IntArray,
) -> bool:
    """Add noise to wrenches and round them.

    Args:
        wrench: On each leg's transducer, sensor axes, (N, 6) [N, N m].
        chance: Standard normal numbers, a row a slot of the unit, (6, 6).
        noise: Standard deviation of each axis, (6,).
        rating: Largest force or moment of each axis, (6,).
        used: Legs that have a transducer, (M,).
        slots: Slot of each of them, (M,).
        counts_per_unit: Counts of a newton, and of a newton metre.
        counts: By slot, (6, 6); those of the slots are written.

    Returns:
        Whether all of them are within their ratings; if not, what is written is not bounded.
    """
    within = True
    for m in range(len(used)):
        leg, slot = used[m], slots[m]
        for axis in range(len(noise)):
            sensed = wrench[leg, axis] + chance[slot, axis] * noise[axis]
            within = within and not abs(sensed) > rating[axis]
            counts[slot, axis] = int(np.rint(sensed * counts_per_unit))
    return within


def prepare() -> None:
    """Load or make the machine code, so that no record waits for it."""
    compile_for(
        sensed_counts, *given(2, 2, 1, 1), *given(1, 1, kind=COUNT), COUNT, *out(2, kind=COUNT)
    )
