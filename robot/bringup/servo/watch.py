"""``bigant servo watch``: readings of the servos and what happened on the wire, live."""

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import TextIO

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.frames import ALERT
from drivers.dynamixel.mx106 import hardware_error_names, joint_state
from drivers.dynamixel.stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US, BusStats
from model.errors import BusError, ConnectionLost
from model.values.readings import ServoReadings
from robot.bringup.servo.access import bus_of
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.screen_fit import Screen
from robot.console.table import number_text
from robot.requests.servo import ServoWatchRequest
from robot.run.operator import Interrupts

SCREEN_PERIOD_NS = 250_000_000
LINES_PERIOD_NS = 1_000_000_000
BAR = 40


def watch_servos(request: ServoWatchRequest) -> ExitCode:
    """Watch.

    Returns:
        OK, or HARDWARE when a servo was silent at the end.

    Raises:
        BusError: The port cannot be opened, or vanishes.
    """
    bus = bus_of(request.port, request.baud, load_robot(request.robot))
    bus.open()
    try:
        with Interrupts() as interrupts:
            _introduce(bus)
            last = watch(
                bus,
                None if request.json else sys.stdout,
                seconds=request.seconds,
                rate_hz=request.rate_hz,
                stopped=lambda: interrupts.count > 0,
            )
    finally:
        bus.close()
    if request.json:
        print(json.dumps(_as_json(bus, last), indent=2))
    else:
        print("\n".join(stats_lines(bus.stats)))
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
        print(f"warning: {warning}", file=sys.stderr)


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
                screen.draw(title, table_lines(bus, readings), ["", counters, "Ctrl-C ends"])
            else:
                print(
                    f"{title}  {counters}",
                    *table_lines(bus, readings),
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


def table_lines(bus: ServoBus, readings: ServoReadings) -> list[str]:
    """Return a heading and a line a servo. What is missing is a dash."""
    joints = joint_state(readings, bus.settings)
    age_ms = np.where(readings.age_ns >= 0, readings.age_ns * 1e-6, np.nan)
    columns = (
        ("rad", joints.angle_rad, 3, 9),
        ("rad/s", joints.rate_rad_s, 2, 7),
        ("A", joints.current_a, 2, 6),
        ("V", joints.voltage_v, 1, 6),
        ("degC", joints.temperature_c, 0, 5),
        ("age ms", age_ms, 1, 8),
    )
    heads = "".join(f"{head:>{width}}" for head, _, _, width in columns)
    lines = [f"leg  id   ticks{heads}  errors"]
    for i, name in enumerate(bus.settings.names):
        ticks = f"{readings.position_ticks[i]:7d}" if readings.valid[i] else f"{'-':>7}"
        cells = "".join(number_text(v[i], digits, width) for _, v, digits, width in columns)
        errors = error_words(readings, i)
        lines.append(f"{name:<4} {int(bus.settings.ids[i]):>3} {ticks}{cells}  {errors}")
    return lines


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
    servos = []
    for i, name in enumerate(bus.settings.names):
        valid = bool(readings.valid[i])
        values = {
            "position_ticks": int(readings.position_ticks[i]),
            "angle_rad": float(joints.angle_rad[i]),
            "rate_rad_s": float(joints.rate_rad_s[i]),
            "current_a": float(joints.current_a[i]),
            "voltage_v": float(joints.voltage_v[i]),
            "temperature_c": float(joints.temperature_c[i]),
        }
        servos.append({
            "leg": name,
            "id": int(bus.settings.ids[i]),
            "valid": valid,
            **{key: value if valid else None for key, value in values.items()},
            "errors": error_words(readings, i),
        })  # fmt: skip
    edges = {"round_trip_edges_us": ROUND_TRIP_EDGES_US, "jitter_edges_us": JITTER_EDGES_US}
    return {"servos": servos, "stats": {**asdict(bus.stats), **edges}}
