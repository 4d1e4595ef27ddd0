"""The diagnosis on a Dynamixel XL330 with a pendulum that others measured; see docs/real/xl330.md.

Three questions on the same 16 runs: what the manual's servo lacks with the duty logged, the same without
the duty, and what the servo of the published gain, Coulomb and viscous friction still lacks.
"""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.real_machines import (
    Found,
    bring_in,
    command,
    diagnose,
    keep,
    named,
    put,
    span,
    table,
)
from record.trial.column_map import MAPS

GAINS = (100, 200, 400, 800)
JUDGES = ("lift_and_drop", "sin_time_square")
PWM = "pwm_arm ="
# Published fit of Coulomb and viscous friction (m1), with the right divisor of the gain.
PUBLISHED = """name = "XL330 pendulum, published Coulomb and viscous friction"
kind = "servo_bench"

[joint.arm.motor]
supply_v = 7.4
torque_constant_nm_a = 0.3232
resistance_ohm = 4.764
armature_kg_m2 = 0.00164

[joint.arm.friction]
coulomb_nm = 0.00697
viscous_nm_s = 0.01049

[joint.arm.load]
mass_kg = 0.49
length_m = 0.10
"""


def pendulum(folder: Path, out: Path, pages: Path) -> None:
    """Diagnose the pendulum: all runs in one call, then each gain by itself."""
    print("xl330", flush=True)
    trials = bring_in(folder, "xl330", out)
    hold_out = [word for one in JUDGES for word in ("--hold-out", f"trajectory={one}")]
    whole = diagnose(trials, out / "xl330.html", *hold_out)
    keep(out / "xl330.html", pages)
    put(pages / "xl330.md", "named", f"{whole['verdict']}: {named(whole)}")
    rows = [
        [c["channel"], span(c, "before"), span(c, "after"), c["unit"], f"{change(c):+.0%}"]
        for c in whole["channels"]
    ]
    head = ("channel", "RMS before", "after", "unit", "change")
    put(pages / "xl330.md", "channels", table(head, rows))
    for name, own in (("blind", without_duty(out)), ("published", published(out))):
        words = [str(one) for one in sorted((folder / "xl330_pendulum").glob("*.parquet"))]
        command(["import", *words, "--map", str(own), "--out", str(out / name)])
        put(pages / "xl330.md", name, by_gain(out, name))


def by_gain(out: Path, name: str) -> str:
    """Diagnose each gain by itself; return the table."""
    rows = []
    for gain in GAINS:
        print(name, gain, flush=True)
        found = diagnose(of_gain(out / name, gain), out / f"{name}_{gain}.html")
        shaft = next(one for one in found["channels"] if one["channel"] == "shaft_error")
        size = [f"{shaft[which]:.3g}" for which in ("before", "after")]
        words = [found["verdict"], named(found) or "-", pairs(found)]
        rows.append([str(gain), *words, *size, f"{change(shaft):+.0%}"])
    head = (
        "P gain",
        "verdict",
        "named",
        "indistinguishable from",
        "RMS before, rad",
        "after",
        "change",
    )
    return table(head, rows)


def of_gain(trials: Path, gain: int) -> list[str]:
    """Return the runs of one gain."""
    return sorted(map(str, trials.glob(f"kp{gain}_*.parquet")))


def pairs(found: Found) -> str:
    """Return what is indistinguishable from what."""
    return "; ".join(f"{a} from {b}" for a, b in found["ambiguous_with"]) or "-"


def change(channel: Found) -> float:
    """Return by which share an RMS changed."""
    return float(channel["after"] / channel["before"]) - 1.0


def without_duty(out: Path) -> Path:
    """Write the map without the duty, with the manual's servo beside it."""
    return _map(out / "blind_map", [PWM], ("", ""), (MAPS / "xl330" / "xl330.toml").read_text())


def published(out: Path) -> Path:
    """Write the map of the right gain, with the published servo beside it."""
    return _map(out / "published_map", [], ("0.005754681", "0.0028773405"), PUBLISHED)


def _map(folder: Path, drop: Sequence[str], swap: tuple[str, str], servo: str) -> Path:
    folder.mkdir(parents=True)
    text = (MAPS / "xl330" / "map.toml").read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not line.startswith(tuple(drop) or ("\0",))]
    whole = "\n".join(kept).replace(*swap) if swap[0] else "\n".join(kept)
    (folder / "map.toml").write_text(whole, encoding="utf-8")
    (folder / "xl330.toml").write_text(servo, encoding="utf-8")
    return folder / "map.toml"
