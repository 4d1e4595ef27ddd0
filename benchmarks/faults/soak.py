"""An hour of virtual time with random faults of every kind: nothing wrong may pass for right.

``python -m benchmarks soak`` runs the whole loop (real drivers and SDK, controller, safety gate) at 100 Hz
on virtual devices on a bench (``sim_hw.host.bench_world``). Each reply and datagram is hit by each kind of
fault with probability 1 %, and each kind that lasts is on for 1 % of the time. A run that stops is
followed by the next, until the hour is over.

Checked without the code under test: the bench's currents and forces change with every step in a pattern
that never repeats, so a reading tells when it was taken. A reading marked valid must be what some instant
within its own read gives, in position and current both; a force record must be what the unit sampled
under that sequence number. A leg whose shaft stays behind its goal for more than half a second while the
robot walks, and of which no fault speaks, has been left behind. Every stop is booked to a fault of the
scenario that was on and that can cause it; one without such a fault is a surprise.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.faults.cases import FLIPPED
from benchmarks.faults.witness import Findings, MarkedBench, Witness
from model.errors import BusError, ForceStreamError
from model.values.faults import StopReason
from model.values.gravity import STANDARD_GRAVITY
from model.values.tick import Intent, Request, Tick
from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.control.controller import Controller
from robot.run.loop import run
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.kinds import KINDS, ChanceFault, ScenarioFault
from sim_hw.faults.scenario import Course, parse_scenario

RUN_S = 60.0
SHARE = 0.01
RECOVERY = "\n[safety.recovery]\nmost = 3\nafter_restart = true\n"
# What a kind needs beside its time.
NEEDS: MappingProxyType[str, MappingProxyType[str, object]] = MappingProxyType(
    {
        "mask_change": MappingProxyType({"transducers": (2, 5)}),
        "saturation": MappingProxyType({"transducer": 3}),
        "clock_step": MappingProxyType({"step_s": 40.0}),
        "sample_rate": MappingProxyType({"percent": 20.0}),
    }
)
# Reasons that the policy names for the kinds of faults in here, and the ordinary end.
ALLOWED = frozenset(
    {
        StopReason.COMPLETED,
        StopReason.SERVO_LOST,
        StopReason.SERVO_FAULT,
        StopReason.SERVO_STALLED,
        StopReason.LINK_LOST,
        StopReason.FORCE_LOST,
    }
)
# Kinds that can make the robot stop so, while they are on or shortly after. The last of a line are chances
# that are on all the time: five reads in a row may be hit by accident.
BY_CHANCE = frozenset(name for name, kind in KINDS.items() if issubclass(kind, ChanceFault))
CAUSES: MappingProxyType[StopReason, frozenset[str]] = MappingProxyType({
    StopReason.SERVO_LOST: frozenset({"silent_servo", "brownout"}) | BY_CHANCE,
    StopReason.SERVO_FAULT: frozenset(
        {"overheating", "overload", "brownout", "stuck_shaft", "silent_servo"}
    ),
    StopReason.SERVO_STALLED: frozenset({"stuck_shaft"}),
    StopReason.LINK_LOST: frozenset({"unplug"}),
    StopReason.FORCE_LOST: frozenset({
        "silent_stop", "mask_change", "port_change_stall", "console_stall", "clock_step",
        "rollover", "sample_rate",
    }),
})  # fmt: skip
AFTERMATH_S = 3.0  # what recovery waits for, and until a silence is long enough
TICKS_S = 0.1  # the tick in which torque goes on is a little older than the torque


def random_faults(rng: np.random.Generator) -> tuple[ScenarioFault, ...]:
    """Return faults of every kind: chances of 1 %, and times that are 1 % of a run on average."""
    faults: list[ScenarioFault] = []
    for name, kind in KINDS.items():
        keys = {f.name for f in fields(kind)}
        given: dict[str, Any] = dict(NEEDS.get(name, {}))
        if issubclass(kind, ChanceFault):
            faults.append(kind(**given, rate=SHARE))
            continue
        if "servo" in keys:
            given["servo"] = int(rng.integers(1, 7))
        start_s = float(rng.uniform(1.0, RUN_S))
        duration_s = float(rng.exponential(SHARE * RUN_S))
        faults.append(kind(**given, start_s=start_s, duration_s=duration_s))
    return tuple(faults)


def cause_of(reason: StopReason, faults: Sequence[ScenarioFault], since_torque_s: float) -> str:
    """Return the kind of fault that a stop is booked to; empty if none was on that can cause it."""
    names = {kind: name for name, kind in KINDS.items()}
    known = CAUSES.get(reason, frozenset())
    chance = ""
    for fault in faults:
        name = names[type(fault)]
        end_s = fault.start_s + fault.duration_s + AFTERMATH_S
        if name not in known or not fault.start_s - TICKS_S <= since_torque_s <= end_s:
            continue
        if name not in BY_CHANCE:
            return name
        chance = "chance"
    return chance


def soak(virtual_s: float, seed: int, progress: bool = False, assumed: str = "") -> Findings:
    """Run for so long.

    Args:
        virtual_s: Virtual time [s].
        seed: Seed of everything.
        progress: Whether to print a line a run.
        assumed: What is assumed otherwise about the devices, tables of a scenario.
    """
    config = parse_robot(DEFAULT_ROBOT_FILE.read_text(encoding="utf-8") + RECOVERY)
    findings, began = Findings(), time.perf_counter()
    while findings.virtual_s < virtual_s:
        _one_run(config, [seed, findings.runs], virtual_s - findings.virtual_s, findings, assumed)
        findings.wall_s = time.perf_counter() - began
        if progress and findings.runs % 20 == 0:
            print(f"{findings.virtual_s:6.0f} s of {virtual_s:.0f} s virtual, {findings.wall_s:.0f} s, "
                  f"{findings.runs} runs, {findings.wrong_readings} wrong", flush=True)  # fmt: skip
    return findings


def _one_run(
    config: RobotConfig, seed: list[int], left_s: float, findings: Findings, assumed: str
) -> None:
    rng = np.random.default_rng(seed)
    scenario = replace(
        parse_scenario(assumed, [int(i) for i in config.servo_bus.ids]),
        course=Course(seed=int(rng.integers(2**31)), begins="torque"),
        faults=random_faults(rng),
    )
    # an adapter that holds answers back for a period or more leaves no time for a loop at this rate
    slow = scenario.adapter.latency_timer_s >= 1.0 / config.loop.rate_hz
    weight_n = config.parameters.body.mass * STANDARD_GRAVITY
    worlds: list[MarkedBench] = []

    def make(firmware: FirmwareBank) -> MarkedBench:
        worlds.append(MarkedBench(firmware, config.servo_bus.zeros, weight_n, seed[1]))
        return worlds[-1]

    findings.runs += 1
    began_ns = 1_000_000_000
    rig: Rig | None = None
    try:
        rig = open_in_memory(config, VirtualSettings(seed=seed[1], scenario=scenario), bench=make)
        controller = Controller(config, rig.calibrations, armed=True)
        bus = config.servo_bus
        witness = Witness(worlds[0], findings, bus.names, bus.signs)
        result = run(rig, controller, _Walker(min(RUN_S, left_s)), witness, None)
        findings.reasons[result.reason.name] += 1
        if not result.torque_off:
            findings.torque_kept[result.reason.name] += 1
        by_adapter = slow and result.reason is StopReason.TIMING
        if result.reason is not StopReason.COMPLETED:
            stopped_ns = witness.stopped_ns.get(result.reason, 0)
            since_s = (stopped_ns - (witness.torque_ns or stopped_ns)) * 1e-9
            cause = cause_of(result.reason, scenario.faults, since_s)
            cause = "a slow adapter" if by_adapter else cause
            findings.booked[f"{result.reason.name} by {cause or 'nothing'}"] += 1
            if not cause:
                findings.surprises.append(f"run {seed[1]}: unexplained {result.detail}")
        if result.reason not in ALLOWED and not by_adapter:
            findings.surprises.append(f"run {seed[1]}: {result.reason.name}: {result.detail}")
    except (
        BusError,
        ForceStreamError,
    ) as error:  # a mistake before anything moves: told, not raised
        findings.refused[str(error)[:60]] += 1
    except Exception as error:  # noqa: BLE001 - this is what the soak looks for
        findings.surprises.append(f"run {seed[1]}: {type(error).__name__}: {error}")
    finally:
        now_ns = began_ns if rig is None else rig.clock.now_ns()
        findings.virtual_s += max(1.0, (now_ns - began_ns) * 1e-9)
        if rig is not None:
            rig.close()


class _Walker:
    """Walks for so long, one gait after the other."""

    def __init__(self, duration_s: float) -> None:
        self._duration_s = duration_s
        self._begin_ns: int | None = None

    def request(self, _tick: Tick | None, t_ns: int) -> Request:
        """Return the wish for a tick."""
        self._begin_ns = t_ns if self._begin_ns is None else self._begin_ns
        run_s = (t_ns - self._begin_ns) * 1e-9
        if run_s > self._duration_s:
            return Request(Intent.STOP, "tripod", 0.2, 0.0, StopReason.COMPLETED)
        gait = "tripod" if run_s % 40 < 20 else "metachronal"
        return Request(Intent.WALK, gait, 0.2, 0.0, StopReason.NONE)


def lines(found: Findings) -> list[str]:
    """Return the findings in lines."""
    return [
        f"{found.virtual_s:,.0f} s virtual in {found.wall_s:,.0f} s, {found.ticks:,} ticks, "
        f"{found.runs} runs",
        f"servo readings taken as valid: {found.readings:,}, wrong: {found.wrong_readings}",
        f"force records taken as sound: {found.records:,}, wrong: {found.wrong_records}",
        "runs ended: " + ", ".join(f"{k} {n}" for k, n in found.reasons.most_common()),
        "booked: " + ", ".join(f"{k} {n}" for k, n in found.booked.most_common()),
        f"legs left behind: {found.left_behind.total()}",
        "torque not confirmed off: "
        + (", ".join(f"{k} {n}" for k, n in found.torque_kept.most_common()) or "never"),
        "not begun: " + (", ".join(f"{k} ({n})" for k, n in found.refused.most_common()) or "none"),
        "faults: " + ", ".join(f"{k} {n:,}" for k, n in found.faults.most_common()),
        "not brought back: "
        + (", ".join(f"{k} {n}" for k, n in found.not_recovered.most_common()) or "none"),
        f"surprises: {len(found.surprises)}",
        *found.surprises[:20],
    ]


def main() -> None:
    """Run and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--assumed",
        action="store_true",
        help="each assumption about the devices the other way round",
    )
    parser.add_argument("--json", type=Path, help="write the figures to a file")
    options, _ = parser.parse_known_args()
    if options.assumed:
        for words, tables in FLIPPED.items():
            print(f"== {words}", flush=True)
            print("\n".join(lines(soak(options.seconds, options.seed, assumed=tables))), flush=True)
        return
    found = soak(options.seconds, options.seed, progress=True)
    print("\n".join(lines(found)))
    if options.json is not None:
        figures = {f.name: getattr(found, f.name) for f in fields(found)}
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
