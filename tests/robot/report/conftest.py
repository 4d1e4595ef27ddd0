"""Pages of one walk, for all tests that look at them."""

from pathlib import Path

import pytest

from robot.cli import main as cli


@pytest.fixture(scope="session")
def walk_pages(cycle_walk: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with show.html and odom.html of a walk, robot.html of its robot, model.html of a disk."""
    made = tmp_path_factory.mktemp("pages_of_a_walk")
    assert cli.run(["show", str(cycle_walk), "--out", str(made / "show.html")]) == 0
    assert cli.run(["odom", str(cycle_walk), "--compare", "--out", str(made / "odom.html")]) == 0
    words = ["robot", "show", "--gait", "tripod", "--out", str(made / "robot.html")]
    assert cli.run(words) == 0
    assert cli.run(["model", "run", "disk", "--out", str(made / "model.html")]) == 0
    return made
