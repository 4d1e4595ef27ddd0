"""``bigant servo watch``: readings of the servos and what happened on the wire, live."""

import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict
from typing import TextIO

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.frames import ALERT
from drivers.dynamixel.joints import joint_state
from drivers.dynamixel.registers import hardware_error_names
from drivers.dynamixel.stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US, BusStats
from model.errors import BusError, ConnectionLost
from model.values.readings import ServoReadings
from robot.bringup.servo.access import bus_of
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.program_output import complain
from robot.console.screen_fit import Screen
from robot.console.table import Column, table_lines
from robot.requests.servo import ServoWatchRequest
from robot.run.operator import Interrupts

SCREEN_PERIOD_NS = 250_000_000
LINES_PERIOD_NS = 1_000_000_000
BAR = 40
QUANTITIES = ("angle_rad", "rate_rad_s", "current_a", "voltage_v", "temperature_c")  # of JointState
COLUMNS = (
    Column("leg", width=3),
    Column("id", "d", 2),
    Column("ticks", "d", 6),
    Column("rad", ".3f", 7),
    Column("rad/s", ".2f", 5),
    Column("A", ".2f", 5),
    Column("V", ".1f", 4),
    Column("degC", ".0f"),
    Column("age ms", ".1f", 6),
    Column("errors"),
)


def watch_servos(request: ServoWatchRequest) -> ExitCode:
    """Watch.

    Returns:
        OK, or HARDWARE when a servo was silent at the end.

    Raises:
        BusError: The port cannot be opened, or vanishes.
    """
    bus = bus_of(request.port, request.baud, load_robot(request.robot))
    bus.open()
    with closing(bus), Interrupts() as interrupts:
        _introduce(bus)
        interrupts.begin()
        last = watch(
            bus,
            None if request.json else sys.stdout,
            seconds=request.seconds,
            rate_hz=request.rate_hz,
            stopped=lambda: interrupts.count > 0,
        )
    print_result(_as_json(bus, last), stats_lines(bus.stats), as_json=request.json)
    return ExitCode.OK if last.valid.all() else ExitCode.HARDWARE


def _introduce(bus: ServoBus) -> None:
    """Print what connecting would complain about, and watch all the same: that is what it is for."""
    try:
        warnings = bus.connect().warnings
    except ConnectionLost:
        raise
    except BusError as error:
        warnings = (str(error),)
    for warning in warnings:
        complain(f"warning: {warning}")


def watch(
    bus: ServoBus,
    out: TextIO | None,
    *,
    seconds: float | None,
    rate_hz: int,
    stopped: Callable[[], bool],
) -> ServoReadings:
    """Read at a fixed rate and show it; return the last readings.

    Args:
        bus: The bus, its port open.
        out: Where to draw, None for nowhere.
        seconds: How long, None until stopped [s].
        rate_hz: Reads a second.
        stopped: Whether somebody wants it to end.

    Raises:
        ConnectionLost: The port is gone.
    """
    clock = bus.clock
    screen = Screen(out) if out is not None and out.isatty() else None
    begin_ns = deadline_ns = show_ns = clock.now_ns()
    while True:
        readings = bus.read()
        now_ns = clock.now_ns()
        passed_s = (now_ns - begin_ns) * 1e-9
        done = stopped() or (seconds is not None and passed_s >= seconds)
        if out is not None and (now_ns >= show_ns or done):
            show_ns = now_ns + (SCREEN_PERIOD_NS if screen else LINES_PERIOD_NS)
            title, counters = trip_line(bus.stats, passed_s), counter_line(bus.stats)
            if screen:
                screen.draw(title, reading_lines(bus, readings), ["", counters, "Ctrl-C ends"])
            else:
                print(
                    f"{title}  {counters}",
                    *reading_lines(bus, readings),
                    sep="\n",
                    file=out,
                    flush=True,
                )
        if done:
            if screen:
                screen.leave()
            return readings
        deadline_ns = max(deadline_ns + round(1e9 / rate_hz), now_ns)  # late: no burst to catch up
        clock.sleep_until_ns(deadline_ns)


def reading_lines(bus: ServoBus, readings: ServoReadings) -> list[str]:
    """Return a heading and a line a servo. What is missing is a dash."""
    joints = joint_state(readings, bus.settings)
    rows = [
        (
            name,
            int(bus.settings.ids[i]),
            int(readings.position_ticks[i]) if readings.valid[i] else None,
            *(float(getattr(joints, quantity)[i]) for quantity in QUANTITIES),
            readings.age_ns[i] * 1e-6 if readings.age_ns[i] >= 0 else None,
            error_words(readings, i),
        )
        for i, name in enumerate(bus.settings.names)
    ]
    return table_lines(COLUMNS, rows)


def trip_line(stats: BusStats, seconds: float) -> str:
    """Return how long it has gone on, and how long sync reads take."""
    median = stats.median_round_trip_us
    trip = "no complete read" if median is None else f"half within {median * 1e-3:.2f} ms"
    longest_ms = stats.longest_round_trip_us * 1e-3
    return f"{seconds:8.1f} s  round trips: {trip}, longest {longest_ms:.2f} ms"


def error_words(readings: ServoReadings, index: int) -> str:
    """Return what a servo reports, in words."""
    if not readings.valid[index]:
        return "silent"
    value = int(readings.hardware_error[index])
    if value > 0:
        return ", ".join(hardware_error_names(value))
    if readings.error_byte[index] & ALERT:
        return "alert, cause not read yet"
    return "not read yet" if value < 0 else "none"


def counter_line(stats: BusStats) -> str:
    """Return the counters of the wire."""
    return (
        f"reads {stats.reads}  timeouts {stats.timeouts}  CRC {stats.crc_errors}  "
        f"late {stats.late_replies}  foreign {stats.foreign_replies}  "
        f"noise bytes {stats.noise_bytes}"
    )


def stats_lines(stats: BusStats) -> list[str]:
    """Return both histograms and the counters."""
    return [
        "round trip of complete reads",
        *histogram_lines(stats.round_trips, ROUND_TRIP_EDGES_US),
        f"  longest {stats.longest_round_trip_us * 1e-3:.2f} ms",
        "jitter: change of the time from one read to the next",
        *histogram_lines(stats.jitters, JITTER_EDGES_US),
        f"  largest {stats.largest_jitter_us * 1e-3:.2f} ms",
        counter_line(stats),
    ]


def histogram_lines(counts: tuple[int, ...], edges_us: tuple[int, ...]) -> list[str]:
    """Return a histogram as lines, empty classes at both ends left out."""
    labels = [f"< {edge * 1e-3:g} ms" for edge in edges_us] + [f">= {edges_us[-1] * 1e-3:g} ms"]
    filled = [i for i, count in enumerate(counts) if count]
    if not filled:
        return ["  none"]
    most = max(counts)
    return [
        f"  {labels[i]:>10} {counts[i]:7d}  {'#' * -(-BAR * counts[i] // most)}"
        for i in range(filled[0], filled[-1] + 1)
    ]


def _as_json(bus: ServoBus, readings: ServoReadings) -> dict[str, object]:
    joints = joint_state(readings, bus.settings)
    servos = [
        {
            "leg": name,
            "id": int(bus.settings.ids[i]),
            "valid": bool(readings.valid[i]),
            "position_ticks": int(readings.position_ticks[i]) if readings.valid[i] else None,
            **{quantity: getattr(joints, quantity)[i] for quantity in QUANTITIES},
            "errors": error_words(readings, i),
        }
        for i, name in enumerate(bus.settings.names)
    ]
    edges = {"round_trip_edges_us": ROUND_TRIP_EDGES_US, "jitter_edges_us": JITTER_EDGES_US}
    return {"servos": servos, "stats": {**asdict(bus.stats), **edges}}
