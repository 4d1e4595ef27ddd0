"""What holds for all tests: one thread of linear algebra a process, and how often a property is tried.

A worker of pytest-xdist inherits the environment, so this is in time for all of them.
"""

import gc
import os
from collections.abc import Generator, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import is_hypothesis_test, settings

from bigant.one_thread import one_thread
from tests.import_in_turns import import_own_part_first
from tests.pace import brisk_pace as brisk_pace
from tests.pace import usual_pace as usual_pace
from tests.robot.report.text_only import empty_pictures as empty_pictures
from tests.robot.report.text_only import words_only as words_only
from tests.standing import settled_once as settled_once
from tests.walk_logs import cycle_walk as cycle_walk
from tests.walk_logs import short_walk as short_walk
from tests.walk_logs import walk_with_states as walk_with_states

one_thread()

# No deadline: how long an example takes depends on what else the computer does.
settings.register_profile("usual", deadline=None, max_examples=30)
settings.register_profile("thorough", deadline=None, max_examples=200)


def thorough(config: pytest.Config) -> bool:
    return str(config.option.markexpr) == "thorough"


def pytest_configure(config: pytest.Config) -> None:
    settings.load_profile("thorough" if thorough(config) else "usual")


def pytest_collection(session: pytest.Session) -> None:
    import_own_part_first(session.config)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(
    config: pytest.Config, items: list[pytest.Item]
) -> Generator[None, None, None]:
    """Every property is tried again in `make thorough`, with more examples. Long tests are begun first.

    Each of two workers begins with its half of the tests, and takes of the other's last ones afterwards.
    """
    for item in items if thorough(config) else []:
        if is_hypothesis_test(getattr(item, "obj", None)):
            item.add_marker("thorough")
    yield  # those that are not wanted are taken out
    long = [item for item in items if item.get_closest_marker("long")]
    short = [item for item in items if not item.get_closest_marker("long")]
    half = len(items) // 2 - len(long[::2])
    # those that walk through all modules come early, so that one worker alone parses these
    second = sorted(short[half:], key=lambda item: item.path.parent != Path(__file__).parent)
    items[:] = [*long[::2], *short[:half], *long[1::2], *second]


@pytest.fixture(scope="session", autouse=True)
def modules_stay() -> Iterator[None]:
    """No search for garbage walks through all modules and tests: one takes a third of a second.

    A drive does the same for itself each time, and afterwards undoes it for everything: not here.
    """
    from robot.run import loop

    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000)  # the usual 700 searches after every few ticks
    with pytest.MonkeyPatch.context() as patch:
        nothing = dict.fromkeys(("collect", "freeze", "unfreeze"), lambda: 0)
        patch.setattr(loop, "gc", SimpleNamespace(**nothing))
        yield


@pytest.fixture(scope="session", autouse=True)
def no_nicer_worker() -> Iterator[None]:
    """A viewer lowers its own priority; here it would be that of all tests behind it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "nice", lambda _: 0)
        yield
