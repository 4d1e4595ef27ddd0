"""``bigant servo watch``: position, speed, current, voltage, temperature and errors, live.

Only listens. A table that is redrawn on a terminal, one table a second anywhere else; at the end
histograms of round trip and jitter and what went wrong on the wire. Ctrl-C ends it.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, TextIO

from model.errors import BusError, ConnectionLost
from robot.exit_codes import ExitCode
from robot.servo_access import add_robot, baud_rate, robot_of

if TYPE_CHECKING:
    from drivers.clock import Clock
    from drivers.servo_bus import ServoBus
    from drivers.servo_stats import BusStats
    from model.signals import ServoReadings

SCREEN_PERIOD_NS = 250_000_000
LINES_PERIOD_NS = 1_000_000_000
BAR = 40


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--port", metavar="PORT", required=True, help="serial port")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate (robot file)")
    add_robot(parser)
    parser.add_argument("--seconds", type=_positive, metavar="S", help="how long (until Ctrl-C)")
    parser.add_argument(
        "--rate-hz", type=_rate, metavar="R", default=50, help="reads a second (50)"
    )
    parser.add_argument("--json", action="store_true", help="last readings and counts as JSON")


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text}")
    return value


def _rate(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 500:
        raise argparse.ArgumentTypeError(f"must be from 1 to 500 Hz, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Watch.

    Returns:
        OK, or HARDWARE when a servo was silent at the end.

    Raises:
        BusError: The port cannot be opened, or vanishes.
    """
    from dataclasses import replace

    from drivers.clock import MonotonicClock
    from drivers.servo_bus import ServoBus
    from drivers.servo_port import BusPort
    from robot.operator import Interrupts

    config = robot_of(options)
    settings = config.servo_bus
    if options.baud is not None:
        settings = replace(settings, baud_rate=options.baud)
    clock = MonotonicClock()
    port = BusPort(options.port, settings.baud_rate, clock)
    bus = ServoBus(port, settings, clock)
    port.openPort()
    try:
        with Interrupts() as interrupts:
            _introduce(bus)
            out = None if options.json else sys.stdout
            last = watch(
                bus,
                clock,
                out,
                seconds=options.seconds,
                rate_hz=options.rate_hz,
                stopped=lambda: interrupts.count > 0,
            )
    finally:
        bus.close()
    if options.json:
        print(json.dumps(_as_json(bus, last), indent=2))
    else:
        print("\n".join(stats_lines(bus.stats)))
    return ExitCode.OK if last.valid.all() else ExitCode.HARDWARE


def _introduce(bus: "ServoBus") -> None:
    """Say what connecting would complain about, and watch all the same: that is what it is for."""
    try:
        warnings = bus.connect().warnings
    except ConnectionLost:
        raise
    except BusError as error:
        warnings = (str(error),)
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)


def watch(
    bus: "ServoBus",
    clock: "Clock",
    out: TextIO | None,
    *,
    seconds: float | None,
    rate_hz: int,
    stopped: Callable[[], bool],
) -> "ServoReadings":
    """Read at a fixed rate and show it; return the last readings.

    Args:
        bus: The bus, its port open.
        clock: Where time comes from.
        out: Where to draw, None for nowhere.
        seconds: How long, None until stopped [s].
        rate_hz: Reads a second.
        stopped: Whether somebody wants it to end.

    Raises:
        ConnectionLost: The port is gone.
    """
    screen = out is not None and out.isatty()
    begin_ns = deadline_ns = clock.now_ns()
    show_ns = begin_ns
    while True:
        readings = bus.read()
        now_ns = clock.now_ns()
        done = stopped() or (seconds is not None and now_ns - begin_ns >= seconds * 1e9)
        if out is not None and (now_ns >= show_ns or done):
            show_ns = now_ns + (SCREEN_PERIOD_NS if screen else LINES_PERIOD_NS)
            lines = table_lines(bus, readings, (now_ns - begin_ns) * 1e-9)
            _draw(out, lines, screen=screen)
        if done:
            return readings
        deadline_ns += round(1e9 / rate_hz)
        if deadline_ns < now_ns:
            deadline_ns = now_ns  # late: no burst to catch up
        clock.sleep_until_ns(deadline_ns)


def _draw(out: TextIO, lines: list[str], *, screen: bool) -> None:
    if screen:
        out.write("\x1b[H" + "".join(f"{line}\x1b[K\r\n" for line in lines) + "\x1b[J")
    else:
        out.write("\n".join(lines) + "\n")
    out.flush()


def table_lines(bus: "ServoBus", readings: "ServoReadings", seconds: float) -> list[str]:
    """Return one screen: a line a servo and one of counters. What is missing is a dash."""
    from drivers.mx106 import joint_state

    joints = joint_state(readings, bus.settings)
    stats = bus.stats
    median = stats.median_round_trip_us
    trip = "no complete read" if median is None else f"half within {median * 1e-3:.2f} ms"
    lines = [
        f"{seconds:8.1f} s  round trips: {trip}, longest "
        f"{stats.longest_round_trip_us * 1e-3:.2f} ms  {counter_line(stats)}",
        "leg  id   ticks      rad   rad/s      A      V  degC   age ms  errors",
    ]
    for i, name in enumerate(bus.settings.names):
        ticks = f"{readings.position_ticks[i]:7d}" if readings.valid[i] else f"{'-':>7}"
        cells = [
            _cell(joints.angle_rad[i], 9, 3),
            _cell(joints.rate_rad_s[i], 8, 2),
            _cell(joints.current_a[i], 7, 2),
            _cell(joints.voltage_v[i], 7, 1),
            _cell(joints.temperature_c[i], 6, 0),
            _cell(readings.age_ns[i] * 1e-6 if readings.age_ns[i] >= 0 else float("nan"), 9, 1),
        ]
        lines.append(
            f"{name:<4} {int(bus.settings.ids[i]):>3} {ticks}{''.join(cells)}  "
            f"{error_words(readings, i)}"
        )
    return lines


def error_words(readings: "ServoReadings", index: int) -> str:
    """Return what a servo reports, in words."""
    from drivers.dynamixel_frames import ALERT
    from drivers.mx106 import hardware_error_names

    if not readings.valid[index]:
        return "silent"
    value = int(readings.hardware_error[index])
    if value > 0:
        return ", ".join(hardware_error_names(value))
    if readings.error_byte[index] & ALERT:
        return "alert, cause not read yet"
    return "not read yet" if value < 0 else "none"


def counter_line(stats: "BusStats") -> str:
    """Return the counters of the wire."""
    return (
        f"reads {stats.reads}  timeouts {stats.timeouts}  CRC {stats.crc_errors}  "
        f"late {stats.late_replies}  foreign {stats.foreign_replies}  "
        f"noise bytes {stats.noise_bytes}"
    )


def stats_lines(stats: "BusStats") -> list[str]:
    """Return both histograms and the counters."""
    from drivers.servo_stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US

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


def _cell(value: float, width: int, digits: int) -> str:
    return (
        f"{value:{width}.{digits}f}" if value == value else f"{'-':>{width}}"
    )  # NaN is not itself


def _as_json(bus: "ServoBus", readings: "ServoReadings") -> dict[str, object]:
    from drivers.mx106 import joint_state
    from drivers.servo_stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US

    joints = joint_state(readings, bus.settings)
    servos = []
    for i, name in enumerate(bus.settings.names):
        heard = bool(readings.valid[i])
        values = {
            "position_ticks": int(readings.position_ticks[i]),
            "angle_rad": float(joints.angle_rad[i]),
            "rate_rad_s": float(joints.rate_rad_s[i]),
            "current_a": float(joints.current_a[i]),
            "voltage_v": float(joints.voltage_v[i]),
            "temperature_c": float(joints.temperature_c[i]),
        }
        servos.append(
            {
                "leg": name,
                "id": int(bus.settings.ids[i]),
                "valid": heard,
                **{key: value if heard else None for key, value in values.items()},
                "errors": error_words(readings, i),
            }
        )
    edges = {"round_trip_edges_us": ROUND_TRIP_EDGES_US, "jitter_edges_us": JITTER_EDGES_US}
    return {"servos": servos, "stats": {**asdict(bus.stats), **edges}}
