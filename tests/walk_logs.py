"""Logs of short walks of the virtual robot, made once for all tests and workers; nobody writes to them."""

import os
from pathlib import Path

import pytest
from filelock import FileLock

from tests.pace import Pace, brisk

SHORT = ("--duration", "0.3", "--frequency-hz", "0.2")
CYCLE = ("--cycles", "1", "--frequency-hz", "0.3")


def walk_log(factory: pytest.TempPathFactory, words: tuple[str, ...], pace: Pace = brisk) -> Path:
    """Return the log of ``bigant drive --virtual-time`` with these words; the first who asks makes it."""
    return _made_once(factory, "".join(("walk", pace.__name__, *words)), words, pace)


def _made_once(
    factory: pytest.TempPathFactory, name: str, words: tuple[str, ...], pace: Pace = brisk
) -> Path:
    """The log of a drive with these words in a folder of a name, which all workers see."""
    from robot.cli.main import run

    folder = factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    folder = folder / name
    folder.mkdir(exist_ok=True)
    path = folder / "walk.mcap"
    with FileLock(folder / "lock"):
        if not path.exists():
            made = folder / "made.mcap"
            with pace():  # whoever asks first
                assert run(["drive", "--virtual-time", *words, "--log", str(made)]) == 0
            made.rename(path)
    return path


@pytest.fixture(scope="session")
def short_walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """It stands up, walks for a third of a second, and stands."""
    return walk_log(tmp_path_factory, SHORT)


@pytest.fixture(scope="session")
def cycle_walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """It walks one cycle of the tripod gait."""
    return walk_log(tmp_path_factory, CYCLE)


@pytest.fixture(scope="session")
def walk_with_states(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short walk whose log holds the controller's state every second."""
    from robot.run import loop

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "STATE_PERIOD_S", 1)
        words = "--hardware virtual --armed --duration 3"
        return _made_once(tmp_path_factory, "walk_with_states", tuple(words.split()))
