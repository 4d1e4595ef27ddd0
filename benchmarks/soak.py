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
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.constants import g as standard_gravity

from benchmarks.fault_matrix import FLIPPED
from drivers.dynamixel.mx106 import CURRENT_UNIT_A, TICK_RAD
from model.errors import BusError, ForceStreamError, RecordError
from model.values.arrays import FloatArray, IntArray
from model.values.faults import FaultKind, StopReason
from model.values.readings import ForceRecord, ServoReadings
from model.values.tick import Intent, Mode, Request, Tick
from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.control.controller import Controller
from robot.run.loop import run
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.kinds import KINDS, STALL_CURRENT_A, ChanceFault, ScenarioFault
from sim_hw.faults.scenario import Course, parse_scenario
from sim_hw.host.bench_world import BenchWorld
from sim_hw.interfaces import MotorReadings

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
# A shaft that makes less than this share of its goal's travel in so long does not follow.
FOLLOW_S, FOLLOW_SHARE, LEAST_TRAVEL_RAD = 0.6, 0.3, 0.15
PATTERN_A = 0.5  # how far the currents' pattern goes
KEPT_STEPS = 200  # half a second


class MarkedBench(BenchWorld):
    """A bench whose currents and forces tell the time.

    Args:
        firmware: The servos' control loops.
        zeros: Ticks at shaft angle 0.
        weight_n: Weight felt.
        seed: Seed of the pattern.
    """

    def __init__(self, firmware: FirmwareBank, zeros: IntArray, weight_n: float, seed: int) -> None:
        super().__init__(firmware, zeros, weight_n)
        self._random = np.random.default_rng(seed)
        self._mark = np.zeros(len(zeros))
        self.past: deque[tuple[int, FloatArray, FloatArray]] = deque(maxlen=KEPT_STEPS)
        self.sampled: deque[tuple[int, FloatArray]] = deque(maxlen=KEPT_STEPS)

    def stepped(self, t_ns: int) -> None:
        """Mark this step and keep what it was."""
        self._mark = self._random.uniform(-PATTERN_A, PATTERN_A, len(self._mark))
        now = self.motors()
        self.past.append((t_ns, now.ticks.copy(), now.current_a))

    def motors(self) -> MotorReadings:
        """The motors, their currents with the mark of this step."""
        now = super().motors()
        return now._replace(current_a=now.current_a + self._mark)

    def wrench(self, t_ns: int) -> FloatArray:
        """Wrench with a mark of its own."""
        felt = super().wrench(t_ns).copy()
        felt[:, :2] += self._random.uniform(-2.0, 2.0, (len(felt), 2))
        self.sampled.append((t_ns, felt))
        return felt


@dataclass(slots=True)
class Findings:
    """What a soak has found so far.

    Attributes:
        virtual_s: Virtual time.
        ticks: Ticks.
        runs: Runs begun.
        refused: Runs that did not begin: devices not found or not set up, in words.
        readings: Servo readings marked valid.
        wrong_readings: Those that no instant of their read gives.
        records: Force records taken as sound.
        wrong_records: Those that the unit never sampled, or too long ago.
        reasons: Why runs ended.
        faults: Faults by kind.
        not_recovered: Why servos were not brought back.
        surprises: Exceptions that nobody expected, and stops that the policy does not know, in words.
        left_behind: Legs that did not follow while the robot walked, with no fault of theirs, by leg.
        booked: Stops by reason and the kind of fault that they are booked to.
        torque_kept: Runs whose torque was not confirmed off, by reason.
        wall_s: Wall time.
    """

    virtual_s: float = 0.0
    ticks: int = 0
    runs: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    readings: int = 0
    wrong_readings: int = 0
    records: int = 0
    wrong_records: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    not_recovered: Counter[str] = field(default_factory=Counter)
    surprises: list[str] = field(default_factory=list)
    left_behind: Counter[str] = field(default_factory=Counter)
    booked: Counter[str] = field(default_factory=Counter)
    torque_kept: Counter[str] = field(default_factory=Counter)
    wall_s: float = 0.0


class Witness:
    """Looks over the loop's shoulder: compares every tick with the world.

    Args:
        world: The world.
        findings: Where the counts go.
    """

    error: RecordError | None = None

    def __init__(
        self, world: MarkedBench, findings: Findings, names: Sequence[str], signs: IntArray
    ) -> None:
        self._world = world
        self._findings = findings
        self._names = names
        self._signs = signs
        self._walked: deque[tuple[int, FloatArray, FloatArray]] = deque()
        self._faulty_ns = dict.fromkeys(names, -(2**62))
        self.torque_ns: int | None = None
        self.stopped_ns: dict[
            StopReason, int
        ] = {}  # when each reason came first; a worse one may follow

    def write(self, tick: Tick) -> None:
        """Look at one tick."""
        self._findings.ticks += 1
        for fault in tick.faults:
            self._findings.faults[fault.kind.name] += 1
            if fault.kind is FaultKind.RECOVERY_FAILED:
                self._findings.not_recovered[fault.detail.split(":")[-1].strip()] += 1
        if tick.inputs.servos is not None:
            self._check_servos(tick.inputs.servos, tick)
        for record in tick.inputs.forces:
            self._check_record(record)
        self.stopped_ns.setdefault(tick.stop_reason, tick.t_ns)
        if self.torque_ns is None and tick.sent.torque:
            self.torque_ns = tick.t_ns
        self._check_motion(tick)

    def _check_motion(self, tick: Tick) -> None:
        """See that every shaft goes where its goals go."""
        for fault in tick.faults:
            self._faulty_ns[fault.source] = tick.t_ns
        if tick.mode is not Mode.WALK or tick.stop_reason is not StopReason.NONE:
            self._walked.clear()
            return
        shafts = self._world.motors().ticks * TICK_RAD * self._signs
        self._walked.append((tick.t_ns, tick.sent.angle_rad, shafts))
        begin_ns, goals, there = self._walked[0]
        if tick.t_ns - begin_ns < FOLLOW_S * 1e9:
            return
        self._walked.popleft()
        asked, done = np.abs(tick.sent.angle_rad - goals), np.abs(shafts - there)
        behind = (asked > LEAST_TRAVEL_RAD) & (done < FOLLOW_SHARE * asked)
        for leg in np.flatnonzero(behind).tolist():
            name = self._names[leg]
            if self._faulty_ns[name] >= begin_ns:
                continue
            self._findings.left_behind[name] += 1
            self._walked.clear()
            if len(self._findings.surprises) < 20:
                words = f"{done[leg]:.2f} of {asked[leg]:.2f} rad"
                self._findings.surprises.append(f"{name} left behind at {tick.t_ns}: {words}")

    def _check_servos(self, servos: ServoReadings, tick: Tick) -> None:
        steps = [s for s in self._world.past if tick.t_ns - 5_000_000 <= s[0] <= servos.t_ns]
        for leg in np.flatnonzero(servos.valid).tolist():
            self._findings.readings += 1
            here = servos.position_ticks[leg]
            amps = servos.current_counts[leg] * CURRENT_UNIT_A
            if not any(fits(here, amps, step, leg) for step in steps):
                self._findings.wrong_readings += 1
                if len(self._findings.surprises) < 20:
                    words = f"{tick.t_ns} leg {leg}: {here} ticks {amps:.3f} A"
                    self._findings.surprises.append(f"wrong reading at {words}")

    def _check_record(self, record: ForceRecord) -> None:
        self._findings.records += 1
        for t_ns, felt in reversed(self._world.sampled):
            if 0 <= record.t_ns - t_ns <= 100_000_000 and _felt(record, felt):
                return
        self._findings.wrong_records += 1
        if len(self._findings.surprises) < 20:
            self._findings.surprises.append(f"wrong record {record.sequence} at {record.t_ns}")


def fits(ticks: int, amps: float, step: tuple[int, FloatArray, FloatArray], leg: int) -> bool:
    """Whether a reading is that of a step.

    Whole turns do not count: a servo may have lost them. Nor does the current of one whose current sensor
    is the fault: it reads 5.2 A then, which the pattern never does.
    """
    _, there, flowing = step
    off = (ticks - there[leg] + 2048) % 4096 - 2048
    right = abs(amps - flowing[leg]) <= 1.01 * CURRENT_UNIT_A
    faulty = abs(amps - STALL_CURRENT_A) < CURRENT_UNIT_A
    return bool(abs(off) <= 1.0 and (right or faulty))


def _felt(record: ForceRecord, felt: FloatArray) -> bool:
    sound = record.present & ~record.saturated
    error = record.counts[:, :2] / COUNTS_PER_N - felt[:, :2]
    return bool((np.abs(error[sound]) < NOISE_N).all())


COUNTS_PER_N = 1e6
NOISE_N = 0.15


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
    weight_n = config.parameters.body.mass * standard_gravity
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
        if result.reason is not StopReason.COMPLETED:
            stopped_ns = witness.stopped_ns.get(result.reason, 0)
            since_s = (stopped_ns - (witness.torque_ns or stopped_ns)) * 1e-9
            cause = cause_of(result.reason, scenario.faults, since_s)
            findings.booked[f"{result.reason.name} by {cause or 'nothing'}"] += 1
            if not cause:
                findings.surprises.append(f"run {seed[1]}: unexplained {result.detail}")
        if result.reason not in ALLOWED:
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
