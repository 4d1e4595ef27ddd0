"""Run the commands whose output README.md shows, and say which shown lines are no longer what they print.

``python docs/write_outputs.py [NAME...]`` writes each output into docs/outputs/; ``--check`` only compares
README.md with the outputs that are there. Numbers that depend on the computer may differ, words may not.
"""

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).resolve().parent
OUTPUTS = DOCS / "outputs"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(\.\d+)?(e-?\d+)?")
WALK = "runs/docs/first_walk.mcap"
TWIN = "runs/docs/twin"


@dataclass(frozen=True, slots=True)
class Shown:
    """Commands with the name of the file that keeps what they print."""

    name: str
    commands: tuple[tuple[str, ...], ...]


def _twin(number: int, seed: int, *more: str) -> tuple[str, ...]:
    gait, hz = (
        ("tripod", "0.1"),
        ("metachronal", "0.1"),
        ("tripod", "0.15"),
        ("metachronal", "0.15"),
    )[number % 4]
    return (
        "sim",
        "run",
        "--gait",
        gait,
        "--frequency-hz",
        hz,
        "--seed",
        str(seed),
        "--fast",
        *more,
    )


WORN = ("--effect", "leg_stiffness@MR:ratio=0.69")
SHOWN = (
    Shown("walk", (
        ("drive", "--gait", "tripod", "--cycles", "3", "--virtual-time", "--log", WALK),
        ("show", WALK),
    )),
    Shown("replay", (("replay", WALK),)),
    Shown("diagnosis", (
        *((*_twin(k, 100 + k), "--out", f"{TWIN}/healthy_{k}.parquet") for k in range(6)),
        *((*_twin(k, 200 + k), *WORN, "--out", f"{TWIN}/trial_{k}.parquet") for k in range(4)),
        ("gap", "diagnose", *(f"{TWIN}/trial_{k}.parquet" for k in range(4)),
         "--reference", *(f"{TWIN}/healthy_{k}.parquet" for k in range(6)), "--jobs", "1",
         "--html", "runs/docs/report.html"),
    )),
)  # fmt: skip


def write(names: tuple[str, ...]) -> None:
    """Run the commands and keep what each group prints."""
    import contextlib
    import io

    from robot import cli

    OUTPUTS.mkdir(exist_ok=True)
    Path(TWIN).mkdir(parents=True, exist_ok=True)
    for one in SHOWN:
        if names and one.name not in names:
            continue
        said = io.StringIO()
        for words in one.commands:
            print("bigant", *words, flush=True)
            with contextlib.redirect_stdout(said):
                code = cli.run(list(words))
            if code != 0:
                sys.exit(f"ended with {code}: {said.getvalue()}")
        (OUTPUTS / f"{one.name}.txt").write_text(said.getvalue(), encoding="utf-8")


def plain(line: str) -> str:
    """Return a line without its numbers and spaces, and with the folder of the README's first walk."""
    return " ".join(NUMBER.sub("#", line.replace("runs/docs/", "runs/")).split())


def differences(readme: str) -> Iterator[str]:
    """Yield each line that README shows as output and that no kept output has, numbers aside."""
    kept = {
        plain(line)
        for path in sorted(OUTPUTS.glob("*.txt"))
        for line in path.read_text(encoding="utf-8").splitlines()
    }
    for language, block in FENCE.findall(readme):
        for line in [] if language else block.splitlines():
            if line.strip() not in {"", "..."} and plain(line) not in kept:
                yield line


def main() -> None:
    """Write, compare, and end with 1 where README shows what is not printed."""
    if "--check" not in sys.argv:
        write(tuple(sys.argv[1:]))
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    stale = list(differences(readme))
    for line in stale:
        print(f"README.md shows what is not printed: {line}")
    if stale:
        sys.exit(1)
    print("README.md shows what is printed (numbers aside)")


if __name__ == "__main__":
    main()
