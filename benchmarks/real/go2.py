"""The diagnosis on the twelve leg joints of a Go2 that others measured; see docs/real/go2.md."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.real.machines import Bar, Found, alone, command, diagnose, keep, put, table
from robot.console.screen_fit import WIDTH, wrapped

MAP = Path(__file__).resolve().parents[2] / "docs" / "real" / "go2_map.toml"
FRICTION = "joint_friction_at_every_joint"
DECOYS = ("command_delay", "play_at_every_joint", "coulomb_friction_at_every_joint", FRICTION)
SHOWN = ("RR_thigh", "RR_calf")
PARTS = ("coulomb_nm", "viscous_nm_s", "armature_kg_m2")
# Published for these joints: Coulomb [N m], viscous [N m s/rad], armature [kg m2].
PUBLISHED = {
    "FL_hip": (0.2884, 0.1531, 0.0010), "FL_thigh": (0.1739, 0.2406, 0.0197),
    "FL_calf": (1.0151, 0.1450, 0.0356), "FR_hip": (0.1835, 0.2628, 0.0129),
    "FR_thigh": (0.2386, 0.1420, 0.0135), "FR_calf": (0.4912, 0.1728, 0.0371),
    "RL_hip": (0.1550, 0.2243, 0.0075), "RL_thigh": (0.1388, 0.2352, 0.0205),
    "RL_calf": (1.3573, 0.1201, 0.0228), "RR_hip": (0.2488, 0.2989, 0.0081),
    "RR_thigh": (0.2484, 0.1983, 0.0139), "RR_calf": (0.7893, 0.1000, 0.0332),
}  # fmt: skip


def quadruped(folder: Path, out: Path, pages: Path) -> list[Bar]:
    """Diagnose all joints in one call, write the corrected model, and try decoys alone."""
    print("go2", flush=True)
    own, trial = folder / "go2_legs", out / "chirp.parquet"
    machine = ("--machine", str(own / "go2_fixed_base.xml"))
    command(["import", str(own / "chirp.npz"), "--map", str(MAP), "--out", str(trial)])
    found = diagnose([str(trial)], out / "go2.html", *machine)
    keep(out / "go2.html", pages)
    page = pages / "go2.md"
    lines = [found["verdict"].upper(), *wrapped(found["sentence"], WIDTH)]
    put(page, "sentence", "\n".join(["```", *lines, "```"]))
    put(page, "joints", joints_table(found))
    put(page, "others", others(found))
    corrected = out / "go2_corrected.xml"
    put(page, "applied", applied([str(out / "go2.json"), "--out", str(corrected)]))
    by = alone([str(trial)], DECOYS, *machine)
    rows = [
        [joint, *(f"{_cut(by[name], joint):.0%}" for name in DECOYS)]
        for joint in SHOWN
    ]  # fmt: skip
    put(page, "decoys", table(("joint", *DECOYS), rows))
    return bars_of(found)


def bars_of(found: Found) -> list[Bar]:
    """Return what should come out, and what did."""
    of, names = "[Go2](go2.md), 12 joints in one call", [one["effect"] for one in found["causes"]]
    late = {"command_delay", "servo_lag", "stamp_delay"} & {*names}
    sizes = {
        joint: found["causes"][0]["parameters"].get(f"coulomb_nm@{joint}", 0.0)
        for joint in PUBLISHED
    }
    calves = [joint for joint in PUBLISHED if joint.endswith("calf")]
    largest = sorted(sizes, key=lambda joint: -sizes[joint])[: len(calves)]
    off = [sizes[joint] / PUBLISHED[joint][0] - 1.0 for joint in calves]
    before, after = mean_rms_rad(found)
    return [
        Bar(of, "joint friction of all joints first, no delay", ", ".join(dict.fromkeys(names)),
            names[0] == FRICTION and not late),
        Bar(of, "mean RMS -70 %", f"{after / before - 1:+.0%}", after / before <= 0.3),
        Bar(of, "calves have most friction", ", ".join(largest), {*largest} == {*calves}),
        Bar(of, "Coulomb of each calf within 25 % of the published",
            ", ".join(f"{one:+.0%}" for one in off), max(map(abs, off)) <= 0.25),
    ]  # fmt: skip


def mean_rms_rad(found: Found) -> tuple[float, float]:
    """Return the RMS of shafts behind their commands before and after, mean over the joints."""
    shafts = [c for c in found["channels"] if c["channel"] == "shaft_error"]
    before, after = (sum(c[when] for c in shafts) / len(shafts) for when in ("before", "after"))
    return before, after


def joints_table(found: Found) -> str:
    """Return sizes of each joint against the published ones, with RMS before and after."""
    (cause,) = [one for one in found["causes"] if one["effect"] == FRICTION]
    shafts = {c["joint"]: c for c in found["channels"] if c["channel"] == "shaft_error"}
    rows = []
    for joint, published in PUBLISHED.items():
        cells = [joint]
        for part, digits, known in zip(PARTS, (2, 2, 3), published, strict=True):
            size, error = (cause[key][f"{part}@{joint}"] for key in ("parameters", "errors"))
            cells += [f"{size:.{digits}f} +- {error:.{digits}f}", f"{known:.{digits}f}"]
        rms = (f"{1e3 * shafts[joint][when]:.1f}" for when in ("before", "after"))
        rows.append([*cells, *rms])
    before, after = mean_rms_rad(found)
    blank = [""] * (2 * len(PARTS))
    cut = f"{1e3 * after:.1f} ({after / before - 1:+.0%})"
    rows.append(["mean", *blank, f"{1e3 * before:.1f}", cut])
    head = ("joint", "Coulomb, N m", "published", "viscous, N m s", "published", "armature, kg m2",
            "published", "RMS before, mrad", "after")  # fmt: skip
    return table(head, rows)


def others(found: Found) -> str:
    """Return what is named besides, with probability and share."""
    rows = [
        [
            " at ".join((one["effect"], *one["legs"])),
            f"{one['probability']:.2f}",
            f"{one['shrink']:.0%}",
        ]
        for one in found["causes"]
    ]
    return table(("named", "probability", "explains of the gap"), rows)


def applied(words: Sequence[str]) -> str:
    """Run ``bigant gap apply``; return what it says of the gap through the written file."""
    said = command(["gap", "apply", *words])
    lines = [line for line in said.splitlines() if "RMS over all" in line or "of the gap" in line]
    return "\n".join(["```", *(line.strip() for line in lines), "```"])


def _cut(one: Found, joint: str) -> float:
    (cut,) = [c["cut"] for c in one["channels"] if c["joint"] == joint]
    return float(cut)
