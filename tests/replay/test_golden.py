"""Golden logs replay equal, compiled or not, and say in metres and newtons what has changed if not.

``make golden`` writes the CSVs (and, where outputs have changed, the logs) anew; see docs/replay.md.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from robot.replay.fields import FIELDS
from robot.replay.ticks import replay_log
from tests.replay.golden import FOLDER, NAMES, indicator, log_of, read_rows, replayed, same, settled

pytest_plugins = ("robot.replay.pytest_plugin",)

ROOT = Path(__file__).resolve().parents[2]
LARGEST_TOTAL = 600_000
pytestmark = pytest.mark.usefixtures("usual_pace")


@pytest.mark.parametrize("name", NAMES)
def test_it_replays_equal(name: str, assert_replays: Callable[..., None]) -> None:
    assert_replays(f"golden/{name}.mcap")


@pytest.mark.parametrize("name", NAMES)
def test_the_indicator_is_that_of_the_commit(name: str) -> None:
    ticks, controller, _ = replayed(log_of(name))
    today = indicator(ticks, controller.config.parameters.legs.names)
    committed = read_rows(name)
    assert today[0] == committed[0]
    changed = [
        f"{before[0]} s {column}: {one} -> {other}"
        for before, after in zip(committed[1:], today[1:], strict=True)
        for column, one, other in zip(today[0], before, after, strict=True)
        if not same(one, other)
    ]
    assert not changed, "make golden, and look at the difference"


def test_they_hold_what_they_are_there_for() -> None:
    modes = {name: {row[1] for row in read_rows(name)[1:]} for name in NAMES}
    assert all("WALK" in found for found in modes.values())
    assert read_rows("faults")[-1][2] == "SERVO_FAULT"
    assert int(read_rows("faults")[-1][3]) > 10
    assert read_rows("tripod")[-1][3] == "0"


def test_they_are_small() -> None:
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < LARGEST_TOTAL


WITHOUT_COMPILER = """
import json, sys
sys.modules["numba"] = None
from pathlib import Path
from model import compiled
from robot.replay.ticks import replay_log
assert not compiled.compiles()
found = [replay_log(Path(path)) for path in sys.argv[1:]]
print(json.dumps([[f.equal, f.equal_bits, f.ticks] for f in found]))
"""


@pytest.mark.soak
def test_without_a_compiler_they_replay_equal_too() -> None:
    paths = [str(log_of(name)) for name in NAMES]
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_COMPILER, *paths],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    found = json.loads(done.stdout)
    assert [equal for equal, _, _ in found] == [True] * len(NAMES)
    assert all(ticks == 90 for _, _, ticks in found)


def test_every_field_was_compared() -> None:
    found = replay_log(log_of("tripod"), scale=0.0)
    assert [(f.stage, f.name) for f in found.fields] == [(f.stage, f.name) for f in FIELDS]


def test_a_number_keeps_its_digits_unless_it_changed() -> None:
    assert same("0.123456789", "0.12345679")
    assert not same("0.123456789", "0.123456799")
    assert same("12.9029986", "12.9029987")
    assert not same("12.9029986", "12.9029996")
    assert same("nan", "nan")
    assert not same("nan", "0")
    assert not same("WALK", "SLOW")
    old, new = [["t_s"], ["0.123456789"], ["2"]], [["t_s"], ["0.12345679"], ["3"]]
    assert settled(old, new) == [["t_s"], ["0.123456789"], ["3"]]
    assert settled([["t_s"]], new) == new
