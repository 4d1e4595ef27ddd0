"""The diagnosis on logs of real machines that others measured; see docs/real/README.md.

``BIGANT_SHARED_DATA=FOLDER python -m benchmarks.real.machines`` runs the commands that the pages show,
in this process, and writes their figures into the pages (docs/real/*.md, *.html, *.png). Nothing else is
done to the data: the column maps come with the program, and no constant is set for one of the sets.
"""

import contextlib
import io
import json
import math
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.real.figures import draw_arm, draw_cube, draw_rig
from gap.rounding import value_words
from robot.cli import main as cli
from robot.report.moving import library
from robot.report.page import with_shared_library

ARM = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll")
PUBLISHED_COUNTS = 14.78
COUNT_RAD = 2 * math.pi / 4096
DECOYS = (
    "command_delay", "servo_lag", "encoder_offset", "encoder_scale",
    "command_delay+servo_lag+encoder_offset", "play",
)  # fmt: skip
CUBE_DECOYS = ("friction_level", "ground_slope", "pose_delay", "coulomb_friction")
RIG_DECOYS = ("encoder_offset", "command_delay", "gravity_droop", "backlash")
LIBRARY = "bokeh.min.js"
PAGES = Path(__file__).resolve().parents[2] / "docs" / "real"
BEGIN, END = "<!-- made: {} -->", "<!-- end: {} -->"
Found = dict[str, Any]


class Bar(NamedTuple):
    """What should come out of a set, what did, and whether that is enough."""

    of: str
    aim: str
    measured: str
    met: bool


def sources(folder: Path) -> tuple[tuple[str, list[str]], ...]:
    """Return the name of each map with its files."""
    return (
        ("so101", sorted(map(str, (folder / "so101_servo_arm").glob("*.npz")))),
        (
            "servo_backlash",
            [str(folder / "uart_servo_backlash" / "logs" / "motor_telemetry_single.csv")],
        ),
        ("sliding_cube", [str(folder / "sliding_cube" / "tosses.npz")]),
        ("xl330", sorted(map(str, (folder / "xl330_pendulum").glob("*.parquet")))),
    )


def bring_in(folder: Path, name: str, out: Path) -> list[str]:
    """Run ``bigant import`` on a set; return the trials."""
    files = next(files for one, files in sources(folder) if one == name)
    command(["import", *files, "--map", name, "--out", str(out / name)])
    return sorted(map(str, (out / name).glob("*.parquet")))


def command(words: Sequence[str]) -> str:
    """Run a command in this process; return what it printed."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = cli.run(list(words))
    if code not in {0, 1}:
        sys.exit(f"bigant {words[0]} ... ended with {code}")
    return said.getvalue()


def diagnose(trials: Sequence[str], out: Path, *more: str) -> Found:
    """Run ``bigant gap diagnose``; return its JSON and leave its page, or no page at ``out`` of .json."""
    told = out.with_suffix(".json")
    page = [] if out == told else ["--html", str(out)]
    command(["gap", "diagnose", *trials, "--jobs", "1", "--json", str(told), *page, *more])
    found: Found = json.loads(told.read_text(encoding="utf-8"))
    return found


def keep(page: Path, pages: Path) -> None:
    """Put a page among the others of a folder; they share one library, which lies beside them."""
    (pages / LIBRARY).write_text(library(), "utf-8")
    (pages / page.name).write_text(with_shared_library(page.read_text("utf-8"), LIBRARY), "utf-8")


def alone(trials: Sequence[str], effects: Sequence[str], *more: str) -> dict[str, Found]:
    """Run ``bigant gap diagnose --alone``; return what each set of effects comes to."""
    words = [word for effect in effects for word in ("--effect", effect)]
    found = json.loads(command(["gap", "diagnose", "--alone", *trials, *words, *more, "--json"]))
    return {"+".join(one["effects"]): one for one in found}


def named(found: Found) -> str:
    """Return the causes of a diagnosis in words."""
    parts = []
    for cause in found["causes"]:
        sizes = [
            f"{name} {value_words(value, cause['errors'][name])}"
            for name, value in cause["parameters"].items()
        ]
        parts.append(f"{cause['effect']} ({', '.join(sizes)})")
    return "; ".join(parts)


def span(channel: Found, which: str, scale: float = 1.0) -> str:
    """Return an RMS with its interval."""
    low, high = (scale * value for value in channel[f"{which}_range"])
    return f"{scale * channel[which]:.3g} [{low:.3g}, {high:.3g}]"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def put(page: Path, name: str, text: str) -> None:
    """Write a piece between its marks in a page."""
    whole = page.read_text(encoding="utf-8")
    head, rest = whole.split(BEGIN.format(name))
    _, tail = rest.split(END.format(name))
    made = f"{head}{BEGIN.format(name)}\n{text}\n{END.format(name)}{tail}"
    page.write_text(made, encoding="utf-8")


def arm(folder: Path, out: Path, pages: Path) -> list[Bar]:
    """Diagnose the arm joint by joint."""
    trials = bring_in(folder, "so101", out)
    rows, decoys, credit, drawn = [], [], [], []
    for joint in ARM:
        print(joint, flush=True)
        page = f"so101_{joint.lower()}.html"
        found = diagnose(trials, out / page, "--joint", joint)
        keep(out / page, pages)
        (shaft,) = found["channels"]
        cut = 1 - shaft["after"] / shaft["before"]
        rivals = sorted({pair[1] for pair in found["ambiguous_with"]})
        rows.append([f"[{joint}]({page})", found["verdict"], named(found), ", ".join(rivals) or "-",
                     span(shaft, "before", 1e3), span(shaft, "after", 1e3), f"{cut:.0%}"])  # fmt: skip
        by = alone(trials, DECOYS, "--joint", joint)
        cuts = [by[name]["channels"][0]["cut"] for name in DECOYS]
        decoys.append([joint, *(f"{one:.0%}" for one in cuts), f"**{cut:.0%}**"])
        late = {one["effect"]: one for one in found["causes"]}
        credit.append(
            [joint, *(_credit(late.get(name)) for name in ("command_delay", "servo_lag"))]
        )
        drawn.append((joint, [*cuts, cut]))
    put(pages / "so101.md", "diagnoses", table(
        ("joint", "verdict", "named, largest share first", "indistinguishable from",
         "RMS before, mrad", "after", "cut"), rows))  # fmt: skip
    heads = ("joint", *(name.replace("+", " + ") for name in DECOYS), "what was named")
    put(pages / "so101.md", "decoys", table(heads, decoys))
    put(pages / "so101.md", "credit", table(("joint", "command_delay", "servo_lag"), credit))
    draw_arm(drawn, DECOYS, pages / "so101.png")
    least, most = (float(pick(cuts[-1] for _, cuts in drawn)) for pick in (min, max))
    measured = f"{least:.0%} to {most:.0%}"
    return [Bar("[SO-101](so101.md)", "RMS cut by 82 % or more", measured, least >= 0.815)]


def _credit(cause: Found | None) -> str:
    if cause is None:
        return "not named"
    (value,) = cause["parameters"].values()
    return (
        f"{1e3 * value:.0f} ms, explains {cause['shrink']:.0%} of the energy "
        f"(alone {cause['shrink_alone']:.0%}, added last {cause['shrink_last']:.0%})"
    )


def rig(folder: Path, out: Path, pages: Path) -> list[Bar]:
    """Diagnose the held servo."""
    print("backlash rig", flush=True)
    trials = bring_in(folder, "servo_backlash", out)
    found = diagnose(trials, out / "backlash.html")
    keep(out / "backlash.html", pages)
    (cause,) = [one for one in found["causes"] if one["effect"] == "backlash"]
    width, error = (cause[key]["width_rad"] / COUNT_RAD for key in ("parameters", "errors"))
    (shaft,) = found["channels"]
    by = alone(trials, RIG_DECOYS)
    named_as = "named: " + "; ".join(one["effect"] for one in found["causes"])
    rows = [[named_as, f"{width:.2f} +- {error:.2f} counts", *_in_counts(shaft)]]
    for name in RIG_DECOYS:
        (size,) = by[name]["causes"][0]["parameters"].items()
        words = f"{size[0]} {size[1]:.3g}"
        rows.append([f"{name} alone, least squares", words, *_in_counts(by[name]["channels"][0])])
    heads = ("", "size", "RMS before, counts", "after", "cut")
    put(pages / "backlash.md", "diagnosis", table(heads, rows))
    draw_rig(Path(trials[0]), cause["parameters"]["width_rad"], pages / "backlash.png")
    measured = f"{width:.2f} +- {error:.2f} counts"
    near = abs(width - PUBLISHED_COUNTS) <= 1.0
    return [Bar("[backlash rig](backlash.md)", "play of 14.78 +- 1 counts", measured, near)]


def _in_counts(shaft: Found) -> list[str]:
    """RMS before and after in counts with intervals, and the cut."""
    spans = [span(shaft, which, 1 / COUNT_RAD) for which in ("before", "after")]
    return [*spans, f"{1 - shaft['after'] / shaft['before']:.0%}"]


def cube(folder: Path, out: Path, pages: Path) -> list[Bar]:
    """Diagnose the sliding cube."""
    print("cube", flush=True)
    trials = bring_in(folder, "sliding_cube", out)
    found = diagnose(trials, out / "cube.html")
    keep(out / "cube.html", pages)
    rows = [
        [c["channel"], span(c, "before"), span(c, "after"), c["unit"],
         f"{1 - c['after'] / c['before']:.0%}"]
        for c in found["channels"]
    ]  # fmt: skip
    put(pages / "cube.md", "named", f"{found['verdict']}: {named(found)}")
    put(pages / "cube.md", "channels", table(
        ("channel", "RMS before", "after", "unit", "cut"), rows))  # fmt: skip
    by = alone(trials, CUBE_DECOYS)
    decoys = [
        [name, ", ".join(f"{k} {v:.3g}" for k, v in one["causes"][0]["parameters"].items()),
         *(f"{c['cut']:.0%}" for c in one["channels"])]
        for name, one in by.items()
    ]  # fmt: skip
    heads = ("alone, least squares", "size", *(f"cut of {c['channel']}" for c in found["channels"]))
    put(pages / "cube.md", "decoys", table(heads, decoys))
    values = {k: v for one in found["causes"] for k, v in one["parameters"].items()}
    draw_cube([Path(one) for one in trials], values, pages / "cube.png")
    first = found["causes"][0]["effect"]
    return [Bar("[cube](cube.md)", "Coulomb friction first", first, first == "coulomb_friction")]


def main() -> None:
    """Diagnose all sets, or those named on the command line, and write the pages."""
    place = os.environ.get("BIGANT_SHARED_DATA", "")
    if not place:
        sys.exit("set BIGANT_SHARED_DATA to the folder of the data sets")
    from benchmarks.real.go2 import quadruped  # which use what is here
    from benchmarks.real.xl330 import pendulum

    ways = {"arm": arm, "rig": rig, "cube": cube, "xl330": pendulum, "go2": quadruped}
    bars: list[Bar] = []
    with tempfile.TemporaryDirectory(prefix="real-") as folder:
        for name in sys.argv[1:] or ways:
            bars += ways[name](Path(place), Path(folder), PAGES)
    rows = [[one.of, one.aim, one.measured, "yes" if one.met else "**no**"] for one in bars]
    made = table(("set", "aim", "measured", "met"), rows)
    print(made)
    if not sys.argv[1:]:
        put(PAGES / "README.md", "bars", made)


if __name__ == "__main__":
    main()
