"""Every fault of the catalogue on the whole loop: what was reported, what the robot did, how fast.

``python -m benchmarks matrix`` (``make reliability``) writes the table into docs/reliability.md;
tests/robot/run/test_fault_matrix.py runs the same cases and holds each to what is expected here. Virtual
time, real drivers, virtual devices on a bench (``sim_hw.host.bench_world``), tripod gait.
"""

import argparse
from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.faults.cases import CASES, FLIPPED, Case
from drivers.dynamixel.units import TICKS_PER_TURN
from model.errors import BusError, ForceStreamError, RecordError
from model.values.arrays import FloatArray
from model.values.faults import FaultKind, StopReason
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import JointCommand
from model.values.tick import Intent, Mode, Request, Tick
from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.control.controller import Controller
from robot.report.page import Section, report_page
from robot.run.loop import run
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.scenario import parse_scenario
from sim_hw.host.bench_world import BenchWorld

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reliability.md"
REPORT = Path("runs") / "fault_matrix.html"
BEGIN, END = "<!-- fault matrix: make reliability -->", "<!-- end of the fault matrix -->"
FAULT_S = 5.5  # after torque went on; the robot walks by then
# A case is over when the robot stands with a reason, or has walked for so long since the last time that it
# did not: until it is at full speed, and one cycle from there, judged by the shafts themselves.
FREQUENCY_HZ = 0.25
CYCLE_S = 1.0 / FREQUENCY_HZ
WALK_S = 1.5 * CYCLE_S
LONGEST_S = 40.0  # who does neither for so long has not decided
FOLLOWED = 0.9  # of what its goals made in that cycle, each shaft must have made
LEAST_TURNS = 0.7  # that the goals must have made: less is no walking
RECOVERY = "\n[safety.recovery]\nmost = 2\nafter_restart = true\n"
# How a case can end under other assumptions; only the first three are right.
OUTCOMES = (
    "as above", "stops, with a reason", "walks on", "does not begin", "leaves a leg behind",
    "stops without a reason",
)  # fmt: skip
# Counters of the drivers, with the words for one and for several.
COUNTED = {
    "timeouts": ("timeout", "timeouts"),
    "crc_errors": ("crc error", "crc errors"),
    "late_replies": ("late reply", "late replies"),
    "foreign_replies": ("foreign reply", "foreign replies"),
    "noise_bytes": ("noise byte", "noise bytes"),
}
STREAM_COUNTED = {
    "missing": ("sample missing", "samples missing"),
    "duplicate": ("sample duplicate", "samples duplicate"),
    "late": ("sample late", "samples late"),
    "malformed": ("datagram malformed", "datagrams malformed"),
    "saturated": ("sample saturated", "samples saturated"),
    "restarts": ("restart of the stream", "restarts of the stream"),
}


@dataclass(frozen=True, slots=True)
class Row:
    """What came of a case.

    Attributes:
        case: The case.
        begun: Whether the run began.
        words: Cause of the stop, or why it did not begin.
        reported: Fault kinds in the ticks after the fault began.
        driver: Counters of both drivers that moved, in words.
        reason: Why it ended.
        path: Modes from the fault on.
        torque_off: Whether every servo confirmed that its torque is off.
        safe_s: From the fault's beginning until the robot stood or was limp; NaN if it walked on.
        left_behind: Legs whose shafts did not turn with the others in the last cycle, if it walked on.
    """

    case: Case
    begun: bool
    words: str
    reported: tuple[str, ...]
    driver: str
    reason: StopReason
    path: tuple[str, ...]
    torque_off: bool
    safe_s: float
    left_behind: tuple[str, ...] = ()

    @property
    def decisions(self) -> tuple[str, ...]:
        """What must not change unseen: all of the row's cells but driver counts and seconds."""
        cells = self.cells
        return cells[0], cells[1], cells[3], cells[4]

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table."""
        if not self.begun:
            return (
                f"`{self.case.kind}`",
                self.case.what,
                self.driver,
                self.words,
                "does not begin",
                "at once",
            )
        done = self.reason is StopReason.COMPLETED
        did = "walks on" if done and self.path == ("WALK",) else " > ".join(self.path)
        did += ", goes on" if done and self.path != ("WALK",) else ""
        did += f", leaves {' and '.join(self.left_behind)} behind" if self.left_behind else ""
        if not done:
            did += f"; {self.reason.name}; " + (
                "torque off" if self.torque_off else "torque off not confirmed"
            )
        safe = "-" if self.safe_s != self.safe_s else f"{self.safe_s:.2f} s"
        return (
            f"`{self.case.kind}`",
            self.case.what,
            self.driver or "-",
            ", ".join(self.reported) or "-",
            did,
            safe,
        )


class _Kept:
    error: RecordError | None = None

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def write(self, tick: Tick) -> None:
        self.ticks.append(tick)


class _Walker:
    """Walks until it has walked a whole cycle since all was well again, and then ends the run at once."""

    def __init__(self, fault_ns: int) -> None:
        self._well_ns = fault_ns
        self._end_ns = fault_ns + round(LONGEST_S * 1e9)

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        stopping = tick is not None and tick.stop_reason is not StopReason.NONE
        if tick is not None and tick.mode is not Mode.WALK:
            self._well_ns = max(self._well_ns, t_ns)
        walked = t_ns > self._well_ns + round(WALK_S * 1e9)
        if (walked or t_ns > self._end_ns) and not stopping:
            return Request(Intent.CUT, "tripod", FREQUENCY_HZ, 0.0, StopReason.COMPLETED)
        return Request(Intent.WALK, "tripod", FREQUENCY_HZ, 0.0, StopReason.NONE)


class _WatchedBench(BenchWorld):
    """The bench, and where its shafts truly were."""

    def __init__(self, firmware: FirmwareBank, config: RobotConfig) -> None:
        weight_n = config.parameters.body.mass * STANDARD_GRAVITY
        super().__init__(firmware, config.servo_bus.zeros, weight_n)
        self.shafts: list[tuple[int, FloatArray]] = []

    def stepped(self, t_ns: int) -> None:
        self.shafts.append((t_ns, self.motors().ticks))

    def turns(self, begin_ns: int, end_ns: int) -> FloatArray:
        """How far each shaft has turned between two times, (N,) [turns]."""
        begin, end = (
            self.shafts[bisect_left(self.shafts, t, key=_time)][1] for t in (begin_ns, end_ns)
        )
        return np.abs(end - begin) / TICKS_PER_TURN


def scenario_text(case: Case) -> str:
    """Return the scenario of a case."""
    start = "" if case.power else f"start_s = {FAULT_S}\n"
    begins = "power" if case.power else "torque"
    return f'seed = 4\nbegins = "{begins}"\n[[fault]]\nkind = "{case.kind}"\n{start}{case.keys}\n'


def run_case(case: Case, assumed: str = "", *, estimate: bool = True) -> Row:
    """Run one case.

    Args:
        case: The case.
        assumed: What is assumed otherwise about the devices, tables of a scenario; see ``FLIPPED``.
        estimate: Whether the estimator runs; no decision depends on it, and it is half of the time.
    """
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    config = parse_robot(text + RECOVERY if case.recovery else text)
    scenario = parse_scenario(scenario_text(case) + assumed, [int(i) for i in config.servo_bus.ids])
    benches: list[_WatchedBench] = []

    def bench(firmware: FirmwareBank) -> BenchWorld:
        benches.append(_WatchedBench(firmware, config))
        return benches[0]

    try:
        rig = open_in_memory(config, VirtualSettings(seed=1, scenario=scenario), bench=bench)
    except (BusError, ForceStreamError) as error:
        return Row(case, False, str(error), (), "", StopReason.NONE, (), True, 0.0)
    try:
        return _walk(case, config, rig, benches[0], estimate=estimate)
    finally:
        rig.close()


def _walk(
    case: Case, config: RobotConfig, rig: Rig, bench: _WatchedBench, *, estimate: bool
) -> Row:
    controller = Controller(config, rig.calibrations, armed=True, estimate=estimate)
    kept = _Kept()
    begin_ns = rig.clock.now_ns()
    fault_ns = begin_ns + round(FAULT_S * 1e9)
    before = _counters(rig)
    result = run(rig, controller, _Walker(fault_ns), kept, None)
    after = [tick for tick in kept.ticks if tick.t_ns >= fault_ns or case.power]
    walked = result.reason is StopReason.EMERGENCY  # our own end, and nothing before it
    reason = StopReason.COMPLETED if walked else result.reason
    moved = {k: n - before[k] for k, n in _counters(rig).items()}
    reported = {f.kind for tick in after for f in tick.faults} - {FaultKind.NO_SUPPORT}
    path: list[str] = []
    for tick in after[:-1] if walked else after:
        if not path or path[-1] != tick.mode.name:
            path.append(tick.mode.name)
    stopped = [t for t in (after[:-1] if walked else after) if t.mode in {Mode.HOLD, Mode.LIMP}]
    safe_s = (stopped[0].t_ns - fault_ns) * 1e-9 if stopped else float("nan")
    names = np.array(config.servo_bus.names)
    behind = names[:0]
    if walked:
        begin, end = _last_cycle(kept.ticks)
        asked = np.abs(end.angle_rad - begin.angle_rad) / (2 * np.pi)
        done = bench.turns(begin.t_ns, end.t_ns)
        behind = names[(asked < LEAST_TURNS) | (done < FOLLOWED * asked)]
    return Row(
        case=case,
        begun=True,
        words=result.detail,
        reported=tuple(sorted(kind.name for kind in reported)),
        driver=driver_words(moved),
        reason=reason,
        path=tuple(path),
        torque_off=result.torque_off,
        safe_s=safe_s,
        left_behind=tuple(str(name) for name in behind),
    )


def _time(step: tuple[int, FloatArray]) -> int:
    return step[0]


def _last_cycle(ticks: Sequence[Tick]) -> tuple[JointCommand, JointCommand]:
    """Return the last goals, and those a cycle before them."""
    sent = [tick.sent for tick in ticks if tick.sent.torque]
    begin_ns = sent[-1].t_ns - round(CYCLE_S * 1e9)
    return next(command for command in sent if command.t_ns >= begin_ns), sent[-1]


def _counters(rig: Rig) -> dict[tuple[str, str], int]:
    """Counts by the words for one and for several."""
    stats, stream = rig.bus.stats, rig.force_counters
    counts = {words: int(getattr(stats, name)) for name, words in COUNTED.items()}
    if stream is not None:
        counts |= {words: int(getattr(stream, name)) for name, words in STREAM_COUNTED.items()}
    return counts


def driver_words(moved: Mapping[tuple[str, str], int]) -> str:
    """Return what drivers counted, without what they counted none of."""
    return ", ".join(f"{n} {one if n == 1 else more}" for (one, more), n in moved.items() if n)


HEAD = (
    "fault",
    "in this case",
    "drivers counted",
    "faults in the ticks",
    "the robot",
    "time to safe",
)


def table(rows: list[Row]) -> str:
    """Return the table in Markdown."""
    out = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    out += ["| " + " | ".join(cell.replace("|", "/") for cell in row.cells) + " |" for row in rows]
    return "\n".join(out)


def matrix_page(cells: Sequence[Sequence[str]]) -> str:
    """Return the table as an HTML report."""
    plain = [[cell.replace("`", "") for cell in row] for row in cells]
    kinds = len({row[0] for row in plain})
    note = (
        f"{len(plain)} scripted cases of {kinds} kinds of faults, in a walk on virtual devices, "
        "virtual time"
    )
    return report_page("Fault matrix", note, [Section("", plain, HEAD)])


def committed() -> list[tuple[str, ...]]:
    """Return the cells of the table that stands in the documentation."""
    text = PAGE.read_text(encoding="utf-8")
    lines = text[text.index(BEGIN) : text.index(END)].splitlines()[3:]
    return [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines if line]


def judged(row: Row) -> str:
    """Return how a case under other assumptions ended, in a word or two; see ``OUTCOMES``."""
    case = row.case
    if not row.begun:
        return "as above" if case.refused else "does not begin"
    if row.left_behind:
        return "leaves a leg behind"
    if row.reason is case.reason and not case.refused:
        return "as above"
    if row.reason is StopReason.COMPLETED:
        return "walks on"
    return "stops, with a reason" if row.words else "stops without a reason"


def under_assumptions() -> None:
    """Run all cases under each flipped assumption; print what differs, and count how they ended."""
    counts: dict[str, Counter[str]] = {}
    for words, tables in FLIPPED.items():
        counts[words] = Counter()
        for case in CASES:
            row = run_case(case, tables)
            ended = judged(row)
            counts[words][ended] += 1
            if ended != "as above":
                print(f"{words} | {case.what} | {ended} | {row.cells[4]} | {row.words}", flush=True)
    print("\n| assumption | " + " | ".join(OUTCOMES) + " |\n|---|" + "---|" * len(OUTCOMES))
    for words, count in counts.items():
        print(f"| {words} | " + " | ".join(str(count[ended]) for ended in OUTCOMES) + " |")


def main() -> None:
    """Run all cases and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--assumed",
        action="store_true",
        help="run them under each assumption about the devices the other way round, and print",
    )
    options, _ = parser.parse_known_args()
    if options.assumed:
        under_assumptions()
        return
    rows = []
    for number, case in enumerate(CASES, 1):
        print(f"{number}/{len(CASES)} {case.kind}: {case.what}", flush=True)
        rows.append(run_case(case))
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    _, tail = rest.split(END)
    PAGE.write_text(f"{head}{BEGIN}\n{table(rows)}\n{END}{tail}", encoding="utf-8")
    REPORT.parent.mkdir(exist_ok=True)
    REPORT.write_text(matrix_page([row.cells for row in rows]), encoding="utf-8")
    print(f"written to {PAGE} and {REPORT}")


if __name__ == "__main__":
    main()
