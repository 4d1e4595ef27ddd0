"""A shaft that reads the same bit for bit while its command moves: frozen, or at rest in its friction.

Play and stiction hold a real shaft still, and an encoder then repeats itself. What gives a frozen reading
away is how it ends: a shaft that breaks loose starts slowly from where it lay, a reading that thaws jumps
to where the shaft has gone meanwhile. One that never thaws is frozen if it came to rest in one step and was
asked for more than it needed to be moved elsewhere in the run.
"""

from collections.abc import Iterator

import numpy as np

from gap.data.columns import Sign, runs
from model.values.arrays import FloatArray

# A shaft may rest bit for bit while its command moves within play and stiction, which are effects of the
# catalogue (to 0.4 rad): shorter stretches and smaller motions are not looked at.
MOST_PLAY_RAD = 0.4
FROZEN_S = 0.5
JUMP_STEPS = 4.0  # usual steps of a moving shaft, that a thaw jumps by
MORE_ERROR = 1.5  # times the error under which the shaft moved elsewhere


def held_shaft(time_s: FloatArray, shaft: FloatArray, command: FloatArray) -> Iterator[Sign]:
    """Look for stretches in which a shaft's reading is frozen.

    Args:
        time_s: (T,).
        shaft: Angle that was read, (T,).
        command: Angle that was asked for, (T,).
    """
    steps = np.abs(np.diff(shaft))
    moving = steps[np.isfinite(steps) & (steps > 0.0)]
    usual = float(np.median(moving)) if len(moving) else 0.0
    error = np.abs(command - shaft)
    spans = []
    for first, last in runs(shaft[1:] == shaft[:-1]).tolist():
        wanted = command[first : last + 1]
        wanted = wanted[np.isfinite(wanted)]
        span = float(time_s[last] - time_s[first])
        if span < FROZEN_S or not len(wanted) or np.ptp(wanted) <= MOST_PLAY_RAD:
            continue
        ended = last + 1 < len(shaft)
        if ended:
            frozen = steps[last] > JUMP_STEPS * usual
        else:
            before = error[:first][np.isfinite(error[:first])]
            needed = float(np.max(before, initial=0.0))
            abrupt = first > 0 and steps[first - 1] >= usual
            frozen = abrupt and float(np.nanmax(error[first:])) > MORE_ERROR * needed
        if frozen:
            spans.append(span)
    if spans:
        words = f"repeats bit for bit for {sum(spans):.1f} s in {len(spans)} stretches while its command"
        yield "frozen", f"{words} moves on", sum(spans) > 0.1 * float(time_s[-1] - time_s[0])
