"""A recorded run as a regression test: equal today, and a robot file with another mass is found out.

python examples/replay_test.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from robot.cli import main as cli
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode

with TemporaryDirectory() as folder:
    log, heavy = Path(folder) / "walk.mcap", Path(folder) / "heavy.toml"
    walk = ["--virtual-time", "--duration", "1", "--frequency-hz", "0.2", "--log", str(log)]
    assert cli.run(["drive", *walk]) == ExitCode.OK

    # what a test of yours would hold: with pytest it is assert_replays("walk.mcap"), see docs/replay.md
    assert cli.run(["replay", str(log)]) == ExitCode.OK

    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    heavy.write_text(text.replace("mass = 6.5", "mass = 6.6"), encoding="utf-8")
    assert cli.run(["replay", str(log), "--robot", str(heavy)]) == ExitCode.VERDICT_FAILED
