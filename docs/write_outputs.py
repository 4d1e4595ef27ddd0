"""Run the commands whose output README.md and the tutorial show, and say which lines they no longer print.

``python docs/write_outputs.py [NAME...]`` writes each output into docs/outputs/; ``--check`` only compares
the pages with the outputs that are there. Numbers that depend on the computer may differ, words may not.
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
FIRST = "runs/docs/first.mcap"
TWIN = "runs/docs/twin"
DEMO = "runs/docs/demo"
LAB = "runs/docs/lab.toml"  # a natural first file: shafts symmetric about the body


@dataclass(frozen=True, slots=True)
class Shown:
    """Commands with the name of the file that keeps what they print."""

    name: str
    commands: tuple[tuple[str, ...], ...]
    code: int = 0


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
    Shown("odometry", (("odom", WALK, "--compare"),)),
    Shown("diagnosis", (
        *((*_twin(k, 100 + k), "--out", f"{TWIN}/healthy_{k}.parquet") for k in range(6)),
        *((*_twin(k, 200 + k), *WORN, "--out", f"{TWIN}/trial_{k}.parquet") for k in range(4)),
        ("gap", "diagnose", *(f"{TWIN}/trial_{k}.parquet" for k in range(4)),
         "--reference", *(f"{TWIN}/healthy_{k}.parquet" for k in range(6)), "--jobs", "1",
         "--html", "runs/docs/report.html"),
    )),
    Shown("tutorial", (
        ("drive", "--virtual-time", "--cycles", "1", "--frequency-hz", "0.2", "--log", FIRST),
        ("log", "info", FIRST),
    )),
    Shown("demo", (
        ("gap", "demo", "--out", DEMO),
        ("gap", "diagnose", f"{DEMO}/trial_1.parquet", "--reference", f"{DEMO}/healthy_1.parquet"),
    )),
    Shown("robot", (
        ("robot", "new", "--name", "Rollo", "--legs", "6", "--leg", "crank", "--servo", "XL430-W250",
         "--out", "runs/docs/rollo.toml", "--overwrite"),
        ("robot", "show"),
    )),
    Shown("robot_tips", (("robot", "show", LAB, "--gait", "tripod"),), code=1),
    Shown("preflight", (("check", "--hardware", "/dev/ttyUSB0", "--force-unit", "none"),), code=1),
)  # fmt: skip
PAGES = (DOCS.parent / "README.md", DOCS / "tutorial.md", DOCS / "robot_file.md")


def write(names: tuple[str, ...]) -> None:
    """Run the commands and keep what each group prints."""
    import contextlib
    import io
    import shutil

    from robot.cli import main as cli

    OUTPUTS.mkdir(exist_ok=True)
    Path(TWIN).mkdir(parents=True, exist_ok=True)
    from robot.console.arguments import DEFAULT_ROBOT_FILE

    lab = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    for shaft, symmetric in (("[-0.115,", "[-0.2,"), ("[0.085,", "[0.0,"), ("[0.285,", "[0.2,")):
        lab = lab.replace(f" {shaft}", f" {symmetric}")
    Path(LAB).write_text(lab, encoding="utf-8")
    for log in (WALK, FIRST):
        Path(log).unlink(missing_ok=True)  # a drive would keep it under another name
    for one in SHOWN:
        if names and one.name not in names:
            continue
        if one.name == "demo":
            shutil.rmtree(DEMO, ignore_errors=True)  # it wants a new folder
        said = io.StringIO()
        for words in one.commands:
            print("bigant", *words, flush=True)
            with contextlib.redirect_stdout(said):
                code = cli.run(list(words))
            if code != one.code:
                sys.exit(f"ended with {code}: {said.getvalue()}")
        (OUTPUTS / f"{one.name}.txt").write_text(said.getvalue(), encoding="utf-8")


def plain(line: str) -> str:
    """Return a line without its numbers and spaces, and with the folder of the README's first walk."""
    return " ".join(
        NUMBER.sub("#", line.replace("runs/docs/", "runs/").replace("twin/", "")).split()
    )


def differences(page: str) -> Iterator[str]:
    """Yield each line that a page shows as output and that no kept output has, numbers aside."""
    kept = {
        plain(line)
        for path in sorted(OUTPUTS.glob("*.txt"))
        for line in path.read_text(encoding="utf-8").splitlines()
    }
    for language, block in FENCE.findall(page):
        for line in [] if language else block.splitlines():
            if line.strip() not in {"", "..."} and plain(line) not in kept:
                yield line


def main() -> None:
    """Write, compare, and end with 1 where a page shows what is not printed."""
    if "--check" not in sys.argv:
        write(tuple(sys.argv[1:]))
    stale = 0
    for path in PAGES:
        for line in differences(path.read_text(encoding="utf-8")):
            stale += 1
            print(f"{path.name} shows what is not printed: {line}")
    if stale:
        sys.exit(1)
    print(f"{', '.join(path.name for path in PAGES)}: what they show is printed (numbers aside)")


if __name__ == "__main__":
    main()
