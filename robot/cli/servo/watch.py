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
from robot.bringup.servo.access import baud_rate, bus_of, robot_of
from robot.console.arguments import add_robot, positive
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.bus import ServoBus
    from model.values.readings import ServoReadings

SCREEN_PERIOD_NS = 250_000_000
LINES_PERIOD_NS = 1_000_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--port", metavar="PORT", required=True, help="serial port")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate (robot file)")
    add_robot(parser)
    parser.add_argument("--seconds", type=positive, metavar="S", help="how long (until Ctrl-C)")
    parser.add_argument(
        "--rate-hz", type=_rate, metavar="R", default=50, help="reads a second (50)"
    )
    parser.add_argument("--json", action="store_true", help="last readings and counts as JSON")


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
    from robot.bringup.servo.lines import stats_lines
    from robot.run.operator import Interrupts

    bus = bus_of(options, robot_of(options))
    bus.open()
    try:
        with Interrupts() as interrupts:
            _introduce(bus)
            out = None if options.json else sys.stdout
            last = watch(
                bus,
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
    out: TextIO | None,
    *,
    seconds: float | None,
    rate_hz: int,
    stopped: Callable[[], bool],
) -> "ServoReadings":
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
    from robot.bringup.servo.lines import table_lines

    clock = bus.clock
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


def _as_json(bus: "ServoBus", readings: "ServoReadings") -> dict[str, object]:
    from drivers.dynamixel.mx106 import joint_state
    from drivers.dynamixel.stats import JITTER_EDGES_US, ROUND_TRIP_EDGES_US
    from robot.bringup.servo.lines import error_words

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
