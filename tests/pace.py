"""How legs move to their places: in tests nearly twice as fast as usual and up to three at a time.

That is most of a walk: at the usual pace, and one leg after the other, a walk of a third of a second takes
ten, for legs move to where the gait begins, and to the stand. The pace and the order are tested in
``tests/gaits/test_plan.py``; logs that were recorded as a drive does it are replayed so (``usual_pace``),
and programs in processes of their own do it anyway.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import groupby

import numpy as np
import pytest

from gaits import moves
from gaits.moves import LegMoves, MovePace
from model.values.arrays import FloatArray, IntArray, readonly

USUAL = (moves.MOVE_SPEED_RAD_S, moves.MOVE_SHARE)
BRISK = (3.8, 1.0)
Pace = Callable[[], AbstractContextManager[None]]
ONE_AFTER_THE_OTHER = LegMoves.sequence


def three_at_a_time(
    t_ns: int, begin_rad: FloatArray, end_rad: FloatArray, order: IntArray, pace: MovePace
) -> LegMoves:
    """As ``LegMoves.sequence``, but up to three legs at once: all of them lift, or land, or stay."""
    one = ONE_AFTER_THE_OTHER(t_ns, begin_rad, end_rad, order, pace)
    takes = one.stop_ns - one.start_ns
    starts = np.full_like(one.start_ns, t_ns)
    stops = starts.copy()
    now = t_ns
    in_air = np.column_stack([np.cos(begin_rad) < 0, np.cos(end_rad) < 0])
    moving = [leg for leg in order if takes[leg] > 0]
    for _, alike in groupby(moving, key=lambda leg: tuple(in_air[leg])):
        together = list(alike)
        for three in (together[first : first + 3] for first in range(0, len(together), 3)):
            starts[three] = now
            stops[three] = now + takes[three]
            now = int(stops[three].max())
    return LegMoves(one.begin_rad, one.end_rad, readonly(starts), readonly(stops))


@contextmanager
def _moving(pace: tuple[float, float], sequence: Callable[..., LegMoves]) -> Iterator[None]:
    """Legs move at a speed and share, in an order."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(moves, "MOVE_SPEED_RAD_S", pace[0])
        patch.setattr(moves, "MOVE_SHARE", pace[1])
        patch.setattr(LegMoves, "sequence", staticmethod(sequence))
        yield


def brisk() -> AbstractContextManager[None]:
    """Legs move to their places fast and up to three at once."""
    return _moving(BRISK, three_at_a_time)


def usual() -> AbstractContextManager[None]:
    """Legs move as in a drive by the command."""
    return _moving(USUAL, ONE_AFTER_THE_OTHER)


@pytest.fixture(scope="session", autouse=True)
def brisk_pace() -> Iterator[None]:
    """All tests but those that use ``usual_pace``."""
    with brisk():
        yield


@pytest.fixture(scope="module")
def usual_pace() -> Iterator[None]:
    """Legs move as in a drive by the command, in a whole module."""
    with usual():
        yield
