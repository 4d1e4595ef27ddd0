"""The witness of the soak: a bench whose readings tell their time, and who compares every tick with it."""

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import takewhile

import numpy as np

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.units import TICK_RAD
from model.errors import RecordError
from model.values.arrays import FloatArray, IntArray
from model.values.faults import FaultKind, StopReason
from model.values.readings import ForceRecord, ServoReadings
from model.values.tick import Mode, Tick
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.kinds import STALL_CURRENT_A
from sim_hw.host.bench_world import BenchWorld
from sim_hw.interfaces import MotorReadings

# A shaft that makes less than this share of its goal's travel in so long does not follow.
FOLLOW_S, FOLLOW_SHARE, LEAST_TRAVEL_RAD = 0.6, 0.3, 0.15
PATTERN_A = 0.5  # how far the currents' pattern goes
KEPT_STEPS = 8000  # twenty seconds: longer than a loop that cannot keep its period stands still
HALF_A_READ_NS = 5_000_000  # a read is stamped in its middle
BEFORE_NS = 5_000_000  # a tick's reading may be of so long before it
OLDEST_RECORD_NS = 100_000_000
COUNTS_PER_N = 1e6
NOISE_N = 0.15


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
        end_ns = servos.t_ns + HALF_A_READ_NS
        begin_ns = tick.t_ns - BEFORE_NS
        recent = takewhile(lambda step: step[0] >= begin_ns, reversed(self._world.past))
        steps = [step for step in recent if step[0] <= end_ns]
        for leg in np.flatnonzero(servos.valid).tolist():
            self._findings.readings += 1
            here = servos.position_ticks[leg]
            amps = servos.current_counts[leg] * MX_106.current_unit_a
            if not any(fits(here, amps, step, leg) for step in steps):
                self._findings.wrong_readings += 1
                if len(self._findings.surprises) < 20:
                    words = f"{tick.t_ns} leg {leg}: {here} ticks {amps:.3f} A"
                    self._findings.surprises.append(f"wrong reading at {words}")

    def _check_record(self, record: ForceRecord) -> None:
        self._findings.records += 1
        for t_ns, felt in reversed(self._world.sampled):
            if record.t_ns - t_ns > OLDEST_RECORD_NS:
                break
            if t_ns <= record.t_ns and _felt(record, felt):
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
    right = abs(amps - flowing[leg]) <= 1.01 * MX_106.current_unit_a
    faulty = abs(amps - STALL_CURRENT_A) < MX_106.current_unit_a
    return bool(abs(off) <= 1.0 and (right or faulty))


def _felt(record: ForceRecord, felt: FloatArray) -> bool:
    sound = record.present & ~record.saturated
    error = record.counts[:, :2] / COUNTS_PER_N - felt[:, :2]
    return bool((np.abs(error[sound]) < NOISE_N).all())
