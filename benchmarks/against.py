"""What a tick costs here and in another checkout, in turns: ``python -m benchmarks.against OTHER``.

Each round starts one process in either checkout, so that what else runs on the computer meets both alike.
``loop`` is that of ``python -m benchmarks``; ``--benchmark`` names another whose lines begin with
microseconds and which both checkouts have. Two logs more, one that each checkout has made (``bigant sim
run --out walk.mcap``), and ``bigant replay`` is timed as well. Prints medians, and the median ratio of the
rounds.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
MAIN = (
    "import sys, importlib, tomllib; sys.argv[0] = 'bigant'; "
    "where = tomllib.load(open('pyproject.toml', 'rb'))['project']['scripts']['bigant']; "
    "module, name = where.split(':'); sys.exit(getattr(importlib.import_module(module), name)())"
)


def output(checkout: Path, *arguments: str) -> str:
    """Run Python in a checkout, its own modules first, and return what it prints."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=checkout, env=environment, text=True,
        capture_output=True, check=True,
    )  # fmt: skip
    return done.stdout


def figures(checkout: Path, log: Path | None, benchmark: str) -> dict[str, float]:
    """One round in one checkout: microseconds by what they are spent on, and the speed of a replay."""
    text = output(checkout, "-m", "benchmarks", benchmark)
    rows = {label: float(us) for us, label in re.findall(r"^ *(\d+) us  (.*)$", text, re.MULTILINE)}
    if log is not None:
        text = output(checkout, "-c", MAIN, "replay", str(log))
        rows["replay, times real time"] = float(re.findall(r"(\d+) times real time", text)[0])
    return rows


def main() -> None:
    """Measure in turns and print a table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.against", description=__doc__)
    parser.add_argument("other", type=Path, help="the other checkout")
    parser.add_argument("logs", nargs="*", type=Path, help="a log of this one and one of the other")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--benchmark", default="loop", help="default: loop")
    options = parser.parse_args()
    logs = options.logs or [None, None]
    rounds = [
        tuple(
            figures(where, log, options.benchmark)
            for where, log in zip((HERE, options.other.resolve()), logs, strict=True)
        )
        for _ in range(options.rounds)
    ]
    for label in rounds[0][0]:
        own, other = ([one[side][label] for one in rounds] for side in (0, 1))
        ratio = statistics.median(a / b for a, b in zip(own, other, strict=True))
        middle = f"{statistics.median(own):8.0f} {statistics.median(other):8.0f}"
        print(f"{middle}  {ratio:.3f}  {label}")


if __name__ == "__main__":
    main()
