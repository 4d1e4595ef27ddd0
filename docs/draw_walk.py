"""Draw the README's walk: docs/figures/walk.gif, two cycles of a robot that walks and slips.

It is what ``bigant show LOG --video`` writes, of the part of the log in which the robot walks.
"""

import tempfile
from pathlib import Path

from robot.cli import main as cli

OUT = Path(__file__).resolve().parent / "figures" / "walk.gif"
WALK = "drive --virtual-time --gait tripod --frequency-hz 0.25 --cycles 2 --steer 0.4 --log"
FROM_S, TO_S = "5", "14.5"  # of the log: it begins to walk, and comes to rest


def main() -> None:
    """Walk, keep the middle of it, and draw it."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        log, middle = Path(folder) / "log.mcap", Path(folder) / "walk.mcap"
        for words in (
            (*WALK.split(), log),
            ("log", "trim", log, "--from", FROM_S, "--to", TO_S, "--out", middle),
            ("show", middle, "--video", OUT, "--overwrite"),
        ):
            if code := cli.run(list(map(str, words))):
                raise SystemExit(code)


if __name__ == "__main__":
    main()
