"""Pages of one walk, for all tests that look at them."""

from pathlib import Path

import pytest

from robot.cli import main as cli
from tests.pace import usual
from tests.walk_logs import CYCLE, walk_log


@pytest.fixture(scope="session")
def shown_walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log that the pages show."""
    return walk_log(tmp_path_factory, CYCLE, usual)


@pytest.fixture(scope="session")
def walk_pages(shown_walk: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with show.html and odom.html of a walk, robot.html of its robot, model.html of a disk."""
    made = tmp_path_factory.mktemp("pages_of_a_walk")
    assert cli.run(["show", str(shown_walk), "--out", str(made / "show.html")]) == 0
    assert cli.run(["odom", str(shown_walk), "--compare", "--out", str(made / "odom.html")]) == 0
    words = ["robot", "show", "--gait", "tripod", "--out", str(made / "robot.html")]
    assert cli.run(words) == 0
    assert cli.run(["model", "run", "disk", "--out", str(made / "model.html")]) == 0
    return made
