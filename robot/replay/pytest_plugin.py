"""A pytest plugin: a log of yours as a regression test in three lines.

Loaded by itself wherever bigant is installed (entry point ``pytest11``); it adds one fixture and imports
nothing heavy until a test asks for it.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

AssertReplays = Callable[..., None]


@pytest.fixture
def assert_replays(request: pytest.FixtureRequest) -> AssertReplays:
    """Return a function that fails the test unless a log replays equal.

    ``assert_replays(log, tolerance=1.0, bus=False)``: ``log`` is a path, looked for beside the test's own
    file; ``tolerance`` a factor on all tolerances, 0 for the same bits; with ``bus`` the recorded bytes
    go through the drivers too.
    """
    folder = request.path.parent

    def check(log: str | Path, *, tolerance: float = 1.0, bus: bool = False) -> None:
        __tracebackhide__ = True
        lines = _differences(folder / log, tolerance, bus)
        if lines:
            pytest.fail("\n".join((f"{log} does not replay equal", *lines)), pytrace=False)

    return check


def _differences(path: Path, tolerance: float, bus: bool) -> list[str]:
    """Return what differs, in words; nothing if the log replays equal."""
    from robot.replay.bus import replay_bus
    from robot.replay.command import result_lines
    from robot.replay.ticks import replay_log

    result = (replay_bus if bus else replay_log)(path, scale=tolerance)
    return [] if result.equal else result_lines(result, only_beyond=True)
