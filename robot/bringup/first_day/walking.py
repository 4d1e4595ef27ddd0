"""Steps 12 and 13: one cycle in the air, one on the floor; loop, gate and watches of ``bigant drive``."""

from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from gaits.catalog import default_gait
from model.values.faults import StopReason
from model.values.tick import Mode, Tick
from record.log.background import BackgroundWriter
from robot.bringup.first_day.curve import turning_curves
from robot.bringup.first_day.day import Day, run_header
from robot.bringup.mapping.motion import TorqueStillOn, current_words, largest
from robot.bringup.preflight.design import design_findings
from robot.bringup.preflight.finding import CheckVerdict, failed, passed, warned
from robot.console.person import Hand, Work
from robot.control.controller import Controller
from robot.design.review import RobotReview, log_warnings, review_for_run
from robot.run.hardware import assemble
from robot.run.header import TappedLog, open_log
from robot.run.loop import no_full_collection, run
from robot.run.operator import Interrupts, Script, ScriptedOperator

CYCLES = 1.0
# Of a turn: each shaft makes one in a cycle.
TURNED = 0.9
DOWN = "put the robot on the floor with two metres of room in front of it, and a hand on the supply switch"


class Watched:
    """``robot.run.loop.Observer`` that keeps what a walk is judged by."""

    def __init__(self) -> None:
        self.faults: dict[str, int] = {}
        self.lag_rad = 0.0
        self.current_a = np.nan
        self.temperature_c = 0.0
        self.begin_rad: np.ndarray | None = None
        self.end_rad: np.ndarray | None = None
        self.t_ns: list[int] = []
        self.angles_rad: list[np.ndarray] = []
        self.sent_rad: list[np.ndarray] = []

    def show(self, tick: Tick) -> None:
        """Take one tick."""
        for fault in tick.faults:
            words = f"{fault.kind.name.lower().replace('_', ' ')} ({fault.source})"
            self.faults[words] = self.faults.get(words, 0) + 1
        joints = tick.joints
        if tick.mode is Mode.WALK and np.isfinite(joints.angle_rad).all():
            if self.begin_rad is None:
                self.begin_rad = joints.angle_rad
            self.end_rad = joints.angle_rad
            self.t_ns.append(tick.t_ns)
            self.angles_rad.append(joints.angle_rad)
            self.sent_rad.append(tick.sent.angle_rad)
            lag = np.abs(joints.angle_rad - tick.sent.angle_rad)
            self.lag_rad = max(self.lag_rad, float(np.nanmax(lag)))
            self.current_a = float(np.fmax(self.current_a, largest(joints.current_a)))
            self.temperature_c = max(self.temperature_c, float(np.nanmax(joints.temperature_c)))


def hung_walk(day: Day) -> None:
    """Step 12: one cycle with the feet in the air; without the force unit, which would feel no weight."""
    if (review := _judged(day)) is not None:
        _walk(day, review, with_forces=False)


def floor_walk(day: Day) -> None:
    """Step 13: one cycle on the floor, all watches on."""
    if (review := _judged(day)) is not None:
        day.person.does(Work(Hand.PUT_DOWN, DOWN))
        _walk(day, review, with_forces=True)


def _judged(day: Day) -> RobotReview | None:
    """Judge the robot file for the walk, as ``bigant drive`` does; None if the robot cannot stand."""
    gait = default_gait(day.config.parameters)
    review = review_for_run(day.config, gait, day.options.frequency_hz)
    findings = tuple(design_findings(review))
    day.note(*findings)
    return None if any(one.verdict is CheckVerdict.FAIL for one in findings) else review


def _walk(day: Day, review: RobotReview, *, with_forces: bool) -> None:
    watched = Watched()
    with ExitStack() as stack:
        interrupts = stack.enter_context(Interrupts())
        wires = day.wires()
        wires = wires if with_forces else replace(wires, links=None)
        rig = assemble(day.config, wires, armed=True)
        stack.callback(rig.close)
        controller = Controller(day.config, rig.calibrations, armed=True)
        gait = review.gaits[0].figures.gait
        frequency_hz = day.options.frequency_hz or controller.book.gaits[gait].frequency_hz
        header = replace(
            run_header(day.config, day.site),
            gait=gait,
            frequency_hz=frequency_hz,
            warnings=log_warnings(review),
        )
        writer = open_log(day.log, header, rig, controller, with_bytes=True)
        log = TappedLog(writer if day.site.virtual else BackgroundWriter(writer), day.tap)
        stack.callback(log.close)
        operator = ScriptedOperator(Script(gait, frequency_hz, cycles=CYCLES), interrupts)
        interrupts.begin()
        with no_full_collection():
            result = run(rig, controller, operator, log, watched)
        stopped = interrupts.count
    if not result.torque_off:
        raise TorqueStillOn
    if stopped:
        raise KeyboardInterrupt
    words = result.reason.name.lower().replace("_", " ")
    found = f"{result.ticks} ticks, ended: {words}" + (
        f" ({result.detail})" if result.detail else ""
    )
    if result.reason is not StopReason.COMPLETED:
        day.note(failed("walk", found, f"look at it: bigant show {day.log}"))
    else:
        day.note(passed("walk", f"{found}; torque off"))
    _shafts(day, watched)
    if watched.faults:
        listed = ", ".join(f"{words} {count} x" for words, count in watched.faults.items())
        day.note(warned("faults", listed, f"bigant show {day.log}"))
    else:
        day.note(passed("faults", "none"))


def _shafts(day: Day, watched: Watched) -> None:
    if watched.begin_rad is None or watched.end_rad is None:
        day.note(failed("shafts", "it never walked", f"look at it: bigant show {day.log}"))
        return
    day.curves.extend(
        turning_curves(
            day.config.servo_bus.names,
            np.array(watched.t_ns),
            np.array(watched.angles_rad),
            np.array(watched.sent_rad),
        )
    )
    turns = np.abs(watched.end_rad - watched.begin_rad) / (2 * np.pi)
    found = (
        f"turned {turns.min():.2f} to {turns.max():.2f} turns; at most {np.degrees(watched.lag_rad):.1f} "
        f"deg behind and {watched.temperature_c:.0f} degC, {current_words(watched.current_a)}"
    )
    late = [n for n, t in zip(day.config.servo_bus.names, turns, strict=True) if t < TURNED]
    if late:
        advice = "does something hold it? turn it by hand, torque off"
        day.note(failed("shafts", f"{found}; {', '.join(late)} stayed behind", advice))
    else:
        day.note(passed("shafts", found))
