"""``bigant check --loop``: the real loop without torque, how late it is, and what would help.

It is the loop of ``bigant drive``: same rig, controller, background log. The advice comes from the
figures: what does not show in them is not advised.
"""

import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.wire.tap import WireTap
from model.values.faults import StopReason
from model.values.tick import Tick
from record.log.background import BackgroundWriter
from record.log.header import RunHeader
from robot.bringup.preflight.computer import HostSettings
from robot.bringup.preflight.finding import Finding, failed, passed, warned
from robot.bringup.preflight.servos import bus_advice, wire_ms
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.header import TappedLog, open_log
from robot.run.loop import RunResult, no_full_collection, run
from robot.run.operator import Interrupts, ScriptedOperator, listening
from robot.run.rig import Rig

PROGRESS_NS = 1_000_000_000
WORTH_MENTIONING_MS = 1.0
# More of the period than this for work, and a small disturbance makes a tick late.
BUSY_SHARE = 0.7


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """How the loop did.

    Attributes:
        period_ms: Its period.
        ticks: Ticks run.
        missed: Periods skipped.
        late_ticks: Ticks later than the robot file's late_limit.
        late_ms: Lateness: 50, 95, 99 and 100 %.
        busy_ms: Work of a tick: 50, 95, 99 and 100 %.
        round_trip_ms: Half of the complete sync reads took no longer; NaN without any.
        wire_ms: What the bytes of one of them take.
        reason: Why it ended.
    """

    period_ms: float
    ticks: int
    missed: int
    late_ticks: int
    late_ms: tuple[float, float, float, float]
    busy_ms: tuple[float, float, float, float]
    round_trip_ms: float
    wire_ms: float
    reason: StopReason


class Lateness:
    """Takes the timing of every tick; ``robot.run.loop.Observer``.

    Args:
        progress: Called once a second with the ticks so far.
    """

    def __init__(self, progress: Callable[[int], None]) -> None:
        self.late_ns: list[int] = []
        self.busy_ns: list[int] = []
        self.missed = 0
        self._progress = progress
        self._next_ns = 0

    def show(self, tick: Tick) -> None:
        """Take one tick."""
        timing = tick.inputs.timing
        self.late_ns.append(timing.lateness_ns)
        self.busy_ns.append(timing.busy_ns)
        self.missed += timing.missed
        if timing.deadline_ns >= self._next_ns:
            self._next_ns = timing.deadline_ns + PROGRESS_NS
            self._progress(len(self.late_ns))


def run_loop(
    rig: Rig,
    config: RobotConfig,
    seconds: float,
    progress: Callable[[int], None],
    log: Path | None = None,
    tap: WireTap | None = None,
) -> LoopFigures:
    """Run the loop without torque, with a log that is thrown away unless it is asked for.

    Args:
        rig: The robot, not armed.
        config: Robot file.
        seconds: How long.
        progress: Called once a second with the ticks so far.
        log: Where the log goes; None throws it away.
        tap: Listens in on the wires of the robot; its bytes go into the log. None for nobody.
    """
    controller = Controller(config, rig.calibrations, armed=False)
    lateness = Lateness(progress)
    with tempfile.TemporaryDirectory() as folder, Interrupts() as interrupts:
        interrupts.begin()
        operator = ScriptedOperator(listening(seconds), interrupts)
        header = RunHeader(robot=config.name, hardware="check")
        path = Path(folder) / "check.mcap" if log is None else log
        writer = BackgroundWriter(
            open_log(path, header, rig, controller, with_bytes=tap is not None)
        )
        sink = writer if tap is None else TappedLog(writer, tap)
        with closing(sink), no_full_collection():
            result = run(rig, controller, operator, sink, lateness)
    return figures_of(lateness, result, rig, config, controller.period_ns)


def figures_of(
    lateness: Lateness, result: RunResult, rig: Rig, config: RobotConfig, period_ns: int
) -> LoopFigures:
    """Return the figures of a run."""
    median_us = rig.bus.stats.median_round_trip_us
    late_ns = np.array(lateness.late_ns)
    return LoopFigures(
        period_ms=period_ns * 1e-6,
        ticks=result.ticks,
        missed=lateness.missed,
        late_ticks=int(np.count_nonzero(late_ns > config.loop.late_limit_s * 1e9)),
        late_ms=_percentiles(lateness.late_ns),
        busy_ms=_percentiles(lateness.busy_ns),
        round_trip_ms=float("nan") if median_us is None else median_us * 1e-3,
        wire_ms=wire_ms(config.servo_bus),
        reason=result.reason,
    )


def _percentiles(values_ns: Sequence[int]) -> tuple[float, float, float, float]:
    p50, p95, p99, most = np.percentile(values_ns, (50, 95, 99, 100)) * 1e-6
    return float(p50), float(p95), float(p99), float(most)


def advice_of(figures: LoopFigures, host: HostSettings) -> list[str]:
    """Return what would help, the largest cause first; nothing if the loop is in time. Pure."""
    advice: list[str] = []
    _, _, late_p99, late_most = figures.late_ms
    busy_p99 = figures.busy_ms[2]
    if figures.round_trip_ms > figures.period_ms / 3:
        advice.append(
            f"half of the sync reads take up to {figures.round_trip_ms:.1f} of {figures.period_ms:g} "
            "ms: " + bus_advice(figures.round_trip_ms, figures.wire_ms, host.latency_timer_ms)
        )
    elif busy_p99 > BUSY_SHARE * figures.period_ms:
        advice.append(
            f"a tick works for {busy_p99:.1f} of {figures.period_ms:g} ms: lower loop.rate"
        )
    if late_p99 <= WORTH_MENTIONING_MS and figures.missed == 0 and figures.late_ticks == 0:
        return advice
    if host.load > host.processors:
        advice.append(
            f"system load is {host.load:.1f} on {host.processors} cores: stop other programs"
        )
    if host.governors and set(host.governors) != {"performance"}:
        advice.append(
            f"the frequency governor is {', '.join(host.governors)}: cpupower frequency-set -g "
            "performance"
        )
    if not host.realtime and host.nice >= 0:
        advice.append(
            "the process has normal priority: start it with nice -n -10, or chrt -f 50, as root"
        )
    elif not host.isolated:
        advice.append("no processor is kept free: boot with isolcpus=N and start with taskset -c N")
    half, twice = 0.5 * host.switch_interval_ms, 2 * host.switch_interval_ms
    if half <= late_p99 <= twice and late_most <= twice:
        advice.append(
            f"lateness is about Python's switch interval of {host.switch_interval_ms:g} ms: the log's "
            "thread holds the interpreter; lower it with sys.setswitchinterval, or drive with --log "
            "none to see the difference"
        )
    return advice


def loop_finding(figures: LoopFigures, host: HostSettings, late_limit_s: float) -> Finding:
    """Judge the loop. Pure."""
    p50, p95, p99, most = figures.late_ms
    found = (
        f"{figures.ticks} ticks of {figures.period_ms:g} ms: late 50 % {p50:.2f}, 95 % {p95:.2f}, "
        f"99 % {p99:.2f}, most {most:.2f} ms; {figures.missed} periods missed; work of a tick 50 % "
        f"{figures.busy_ms[0]:.2f}, 99 % {figures.busy_ms[2]:.2f} ms"
    )
    advice = "; ".join(advice_of(figures, host))
    if figures.reason not in {StopReason.COMPLETED, StopReason.OPERATOR}:
        words = figures.reason.name.lower().replace("_", " ")
        return failed("loop", f"stopped ({words}) after {found}", advice or "see the lines above")
    if p99 > late_limit_s * 1e3 or figures.missed > figures.ticks // 100:
        return failed("loop", found, advice or "find out what else runs on this computer")
    if figures.missed or figures.late_ticks or advice:
        return warned("loop", found, advice or "find out what else runs on this computer")
    return passed("loop", found)
