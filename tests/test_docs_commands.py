"""Commands of the pages are run, not only parsed: all that need no hardware and no more than one log.

What is left out is left out by a rule with its reason below, and other tests run it.
"""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from tests.soaked import soaked
from tests.test_docs import PAGES, ROOT, command_lines
from tests.walk_logs import walk_log

LEFT_OUT = (
    (r"/dev/|--hardware|--armed|--discover|192\.168", "needs a robot"),
    (r"--live|--teleop|sim serve|view \S+$|--ros2", "goes on until it is stopped"),
    (r"\b[A-Z]{2,}\b|\[|\.\.\.", "a placeholder of its page"),
    (r"^(servo|force|check(?! --computer)|devices)", "in real time: tests/robot/bringup/test_check.py"),
    (r"\.rrd", "needs bigant[rerun], 640 MB: tests/robot/view/test_view_command.py"),
    (r"^gap (demo|diagnose|apply|next)|^campaign score|^odom tune", "trials of its own"),
    (r"^sim (run|render)|^campaign (make|unseal)", "walks: tests/robot/virtual/test_twin_run.py"),
    (r"^model (figures|sensitivity)|^replay .*--drive|--bus", "over ten seconds: tests of their own"),
    (r"^report", "folders that only its reader has: tests/robot/test_day_report.py"),
    (r"^bringup --folder (bringup|practice)", "a day: tests/robot/bringup/test_first_day.py"),
    (r"^drive", "walks: tests/robot/run/test_drive.py; the log below is from one"),
    (r" lab/", "data of an example: tests/robot/odometry/test_lab_examples.py"),
    (r"^import (?!--maps)|^log (repair|merge)|lab\.toml|worn_crank", "files that only its reader has"),
    (r"chain\.mcap", "a log of an example: tests/robot/odometry/test_chain_walks.py"),
)  # fmt: skip
LOGS = ("runs/first.mcap", "runs/first_walk.mcap")


def reason_of(words: list[str]) -> str:
    """Why a command is not run here; empty if it is."""
    text = shlex.join(words).replace("'", "")
    return next((why for pattern, why in LEFT_OUT if re.search(pattern, text)), "")


# Pages call the same log by two names: what is the same but for that is run once.
RUN = sorted({
    tuple(word.replace(*LOGS) for word in words)
    for page in PAGES for words in command_lines(page) if not reason_of(words)
})  # fmt: skip


def test_enough_commands_are_run_and_no_rule_is_idle() -> None:
    assert len(RUN) >= 20
    everything = [shlex.join(words).replace("'", "") for p in PAGES for words in command_lines(p)]
    for pattern, why in LEFT_OUT:
        assert any(re.search(pattern, text) for text in everything), why


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as a reader has it after the first walk; it takes over ten seconds."""
    walk = walk_log(tmp_path_factory, ("--cycles", "1", "--frequency-hz", "0.14"))
    place = tmp_path_factory.mktemp("reader")
    (place / "runs").mkdir()
    for name in LOGS:
        shutil.copyfile(walk, place / name)
    (place / "examples").symlink_to(ROOT / "examples")
    return place


def quick(words: tuple[str, ...]) -> bool:
    """All but those that take seconds, which have tests of their own with shorter runs."""
    own_tests = {
        "bringup",
        "check",
        "completion",
        "model",
        "odom",
        "replay",
        "show",
        "robot",
        "view",
    }
    return words[0] not in own_tests


@pytest.mark.parametrize("words", soaked(RUN, quick, lambda words: shlex.join(words)[:60]))
def test_a_command_of_a_page_runs(
    words: tuple[str, ...], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    code = cli.run(list(words))
    # check --computer may well find that this computer is not set up: that is its answer
    wanted = {ExitCode.OK, ExitCode.VERDICT_FAILED} if "--computer" in words else {ExitCode.OK}
    assert code in wanted
