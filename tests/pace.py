"""How fast legs move to their places: in tests nearly twice as fast as usual, for that is most of a walk.

At the usual pace a walk of a third of a second takes ten: legs move to where the gait begins, and to the
stand. The pace itself is tested in ``tests/gaits/test_plan.py``; logs that were recorded at the usual pace
are replayed at it (``usual_pace``), and programs in processes of their own have it anyway.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from gaits import moves

USUAL = (moves.MOVE_SPEED_RAD_S, moves.MOVE_SHARE)
BRISK = (3.8, 1.0)


@contextmanager
def pace(speed_rad_s: float, share: float) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(moves, "MOVE_SPEED_RAD_S", speed_rad_s)
        patch.setattr(moves, "MOVE_SHARE", share)
        yield


@pytest.fixture(scope="session", autouse=True)
def brisk_pace() -> Iterator[None]:
    """All tests but those that use ``usual_pace``."""
    with pace(*BRISK):
        yield


@pytest.fixture(scope="module")
def usual_pace() -> Iterator[None]:
    """Legs move as in a drive by the command, in a whole module."""
    with pace(*USUAL):
        yield
