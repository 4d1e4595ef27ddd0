"""Steps 7 and 8: reboots timed, and the loop without torque for ten minutes."""

from contextlib import closing, nullcontext

import numpy as np

from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.reboot import REBOOT_LIMIT_S
from drivers.dynamixel.units import TICKS_PER_TURN
from model.errors import BusError
from robot.bringup.first_day.curve import DayCurve
from robot.bringup.first_day.day import Day
from robot.bringup.preflight.computer import host_settings
from robot.bringup.preflight.finding import failed, passed, skipped, warned
from robot.bringup.preflight.loop import loop_finding, run_loop
from robot.console.person import Hand, Work
from robot.console.progress import StatusLine
from robot.run.hardware import assemble

# What configure needs afterwards, at most; slower servos make recovery in the loop hopeless.
SLOW_S = 1.0


def reboots(day: Day) -> None:
    """Step 7: reboot each servo several times; how long is it deaf, what does it forget?"""
    bus = day.bus()
    bus.connect()
    name = bus.settings.names[0]
    words = f"torque is off: turn the shaft of {name} by hand by one whole turn, either way"
    day.person.does(Work(Hand.TURN_ONCE, words, name))
    with closing(bus):
        servos = bus.servos()
        start = servos[0].read("present_position")
        times = {servo.leg: [_timed(servo) for _ in range(day.options.reboots)] for servo in servos}
        end = servos[0].read("present_position")
        on = [servo.leg for servo in servos if servo.read("torque_enable")]
    day.curves.extend(
        DayCurve(leg, "reboot", "deaf [s]", tuple(range(1, len(some) + 1)), tuple(some))
        for leg, some in times.items()
    )
    every = np.array([one for some in times.values() for one in some])
    middle = float(np.median(every))
    found = (
        f"{len(every)} reboots: deaf for {middle:.3f} s ({every.min():.3f} to {every.max():.3f})"
    )
    how = f"{day.options.reboots} reboots of each of {len(servos)} servos, " + found.split(": ")[1]
    day.settled("servo", "restart_s", round(middle, 3), how)
    slow = [leg for leg, some in times.items() if max(some) > SLOW_S]
    if slow:
        advice = "a servo that reboots in a run is away for so long: check its supply"
        day.note(warned("reboot", f"{found}; {', '.join(slow)} over {SLOW_S:g} s", advice))
    else:
        day.note(passed("reboot", found))
    if on:
        day.note(failed("torque", f"on after a reboot: {', '.join(on)}", "cut the power"))
    lost = round((start - end) / TICKS_PER_TURN)
    inside = 0 <= end < TICKS_PER_TURN
    turned = f"{name} from {start} to {end} ticks: "
    if not 0 <= start < TICKS_PER_TURN and inside:
        day.note(passed("turns", f"{turned}{lost:+d} turns forgotten, as the driver reckons"))
    elif inside:
        advice = "turn it by hand by a whole turn first, and repeat this step"
        day.note(warned("turns", f"{turned}it stood within one turn before", advice))
    else:
        advice = "the driver reckons that turns are forgotten: do not allow [safety.recovery]"
        day.note(failed("turns", f"{turned}turns are kept", advice))


def _timed(servo: CheckedServo) -> float:
    """Reboot a servo; return how long it is deaf from its word that it will [s].

    That is half way between the last request that it misses and the first that it answers.

    Raises:
        BusError: It does not say so, or does not come back.
    """
    clock = servo.port.clock
    if not servo.reboot():
        raise BusError(f"{servo.leg} (id {servo.servo_id}) did not answer to its reboot")
    began_ns = missed_ns = clock.now_ns()
    while (asked_ns := clock.now_ns()) - began_ns < REBOOT_LIMIT_S * 1e9:
        if servo.answers():
            return ((missed_ns + asked_ns) / 2 - began_ns) * 1e-9
        missed_ns = asked_ns
    raise BusError(
        f"{servo.leg} (id {servo.servo_id}) did not come back within {REBOOT_LIMIT_S:g} s: switch its "
        "power off and on"
    )


def loop(day: Day) -> None:
    """Step 8: the loop of ``bigant drive`` without torque; how late is it, how long do answers take?"""
    seconds = day.options.loop_s
    with (
        nullcontext() if day.site.virtual else StatusLine() as status,
        closing(assemble(day.config, day.wires(), armed=False)) as rig,
    ):

        def show(ticks: int) -> None:
            if status is not None:
                status.step(f"the loop without torque, {seconds:g} s: {ticks} ticks ...")

        figures = run_loop(rig, day.config, seconds, show, day.log, day.tap)
        host = host_settings(rig.bus.latency_timer_ms)
        stats, forces = rig.bus.stats, rig.force_counters
    day.note(loop_finding(figures, host, day.config.loop.late_limit_s))
    if day.site.virtual:
        day.note(skipped("lateness", "virtual time: nothing can be late in it"))
    legs = len(day.config.servo_bus.names)
    lost = f"{stats.timeouts} of {stats.reads * legs} answers lost, {stats.crc_errors} damaged"
    round_trip = stats.median_round_trip_us
    if round_trip is not None:
        lost += (
            f"; round trips 50 % within {round_trip * 1e-3:g} ms, longest "
            f"{stats.longest_round_trip_us * 1e-3:.2f} ms"
        )
    good = stats.timeouts + stats.crc_errors <= stats.reads * legs // 1000
    advice = "check cables and plugs: bigant servo watch"
    day.note(passed("answers", lost) if good else warned("answers", lost, advice))
    if forces is not None:
        words = f"{forces.records} records, {forces.missing} lost, {forces.late} late"
        well = forces.missing <= forces.records // 100
        advice = "bring unit and access point closer, or change the channel"
        day.note(passed("force records", words) if well else warned("force records", words, advice))
