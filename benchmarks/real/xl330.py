"""The diagnosis on a Dynamixel XL330 with a pendulum that others measured; see docs/real/xl330.md.

Three questions on the same 16 runs: what the manual's servo lacks with the duty logged, the same without
the duty, and what the servo of the published gain, Coulomb and viscous friction still lacks.
"""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.real.machines import (
    Bar,
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


def pendulum(folder: Path, out: Path, pages: Path) -> list[Bar]:
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
    each: dict[str, list[Found]] = {}
    for name, own in (("blind", without_duty(out)), ("published", published(out))):
        words = [str(one) for one in sorted((folder / "xl330_pendulum").glob("*.parquet"))]
        command(["import", *words, "--map", str(own), "--out", str(out / name)])
        each[name], text = by_gain(out, name)
        put(pages / "xl330.md", name, text)
    return bars_of(whole, each["blind"], each["published"])


def bars_of(whole: Found, blind: Sequence[Found], published: Sequence[Found]) -> list[Bar]:
    """Return what should come out, and what did."""
    of = "[XL330](xl330.md), 16 runs in one call"
    first, *others = whole["causes"]
    gain = first["parameters"].get("ratio", 0.0)
    likely = [one["effect"] for one in others if one["probability"] > 0.5]
    cuts = [change(one) for one in whole["channels"]]
    alike = [{name for pair in one["ambiguous_with"] for name in pair} for one in blind]
    motor = {"controller_gain", "supply_voltage", "torque_constant", "winding_resistance"}
    told = sum(motor <= one for one in alike)
    bound = any(
        one["verdict"] == "explained" and any(cause["on_bound"] for cause in one["causes"])
        for one in blind
    )
    loaded = sum(
        any("load_friction" in cause["effect"] for cause in one["causes"]) for one in published
    )
    worst = max(change(_shaft(one)) for one in published)
    return [
        Bar(of, "controller_gain 0.50 +- 0.03 first", f"{first['effect']} {gain:.3f}",
            first["effect"] == "controller_gain" and abs(gain - 0.5) <= 0.03),
        Bar(of, "then friction that grows with load, nothing else above 0.5", ", ".join(likely),
            len(likely) <= 1 and "load_friction" in others[0]["effect"]),
        Bar(of, "RMS -60 % on other motions", ", ".join(f"{one:+.0%}" for one in cuts),
            max(cuts) <= -0.595),
        Bar("[the same](xl330.md) without duty, each gain",
            "gain and motor constants indistinguishable in 4 of 4; none explained on a bound",
            f"{told} of {len(blind)}", told == len(blind) and not bound),
        Bar("[the same](xl330.md), right gain, Coulomb and viscous fitted",
            "load-dependent friction in 3 of 4; held-out runs never worse",
            f"{loaded} of {len(published)}; worst {worst:+.0%}", loaded >= 3 and worst <= 0.0),
    ]  # fmt: skip


def by_gain(out: Path, name: str) -> tuple[list[Found], str]:
    """Diagnose each gain by itself; return what was found, and the table."""
    rows, each = [], []
    for gain in GAINS:
        print(name, gain, flush=True)
        found = diagnose(of_gain(out / name, gain), out / f"{name}_{gain}.html")
        each.append(found)
        shaft = _shaft(found)
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
    return each, table(head, rows)


def _shaft(found: Found) -> Found:
    return next(one for one in found["channels"] if one["channel"] == "shaft_error")


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
