"""``bigant servo zero``: the servo_zero line of the robot file.

Turn every shaft by hand to shaft angle 0 (mid-stance), torque off, and run it. Takes the median of
several readings, refuses shafts that move, and prints the line for the robot file. --robot-out writes a
copy of the robot file with these zeros in it, --write a record of them with servo ids and models. No
file that exists is ever changed.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import BusError, ConfigError
from record.toml_file import toml_text
from robot.bringup.servo.access import baud_rate, bus_of, robot_of, write_new
from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.bus import ServoBus
    from model.values.arrays import BoolArray

READS = 25
TRIES = 75  # a read with a lost answer is made again, so often at most
READ_PERIOD_S = 0.02
# Two counts of noise are usual; more is a shaft that moves.
LARGEST_SPREAD_TICKS = 8


@dataclass(frozen=True, slots=True)
class ServoZero:
    """One shaft's zero.

    Attributes:
        leg: Leg name.
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        zero_ticks: Median position, within one turn, 0 to 4095.
        spread_ticks: Largest less smallest reading.
    """

    leg: str
    servo_id: int
    model: int
    firmware: int
    zero_ticks: int
    spread_ticks: int


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--port", metavar="PORT", required=True, help="serial port")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate (robot file)")
    add_robot(parser)
    parser.add_argument(
        "--robot-out", type=Path, metavar="FILE", help="the robot file with these zeros"
    )
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="zeros, servo ids, models (.toml)"
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Read and print.

    Raises:
        BusError: A servo does not answer, or a shaft moves.
        ConfigError: A file to be written exists or cannot be written.
    """
    config = robot_of(options)
    for option, path in (("--write", options.write), ("--robot-out", options.robot_out)):
        if path is not None and path.exists():
            raise ConfigError(option, f"{path} exists; choose another name")
    bus = bus_of(options, config)
    try:
        bus.connect()
        zeros = measure_zeros(bus)
    finally:
        bus.close()
    line = zero_line(zeros)
    if options.json:
        print(json.dumps({"servos": [asdict(z) for z in zeros], "line": line}, indent=2))
    else:
        for z in zeros:
            print(f"{z.leg}  id {z.servo_id}  zero {z.zero_ticks}  spread {z.spread_ticks} ticks")
        print(f"for [legs] of the robot file:\n{line}")
    if options.write is not None:
        write_new(options.write, calibration_text(zeros, config.name), "--write")
        if not options.json:
            print(f"kept in {options.write}")
    if options.robot_out is not None:
        from robot.config.edit import with_servo_zeros

        text = with_servo_zeros(config.text, [zero.zero_ticks for zero in zeros])
        write_new(options.robot_out, text, "--robot-out")
        if not options.json:
            print(f"robot file with these zeros: {options.robot_out}")
    return ExitCode.OK


def measure_zeros(bus: "ServoBus") -> list[ServoZero]:
    """Return the median position of every servo.

    Args:
        bus: The bus, connected.

    Raises:
        BusError: A servo does not answer often enough, or a shaft moves.
    """
    import numpy as np

    from drivers.dynamixel.mx106 import TICKS_PER_TURN

    ticks, heard = [], np.zeros(len(bus.settings.names), dtype=int)
    for _ in range(TRIES):
        readings = bus.read()
        heard += readings.valid
        if readings.valid.all():
            ticks.append(readings.position_ticks)
            if len(ticks) == READS:
                break
        bus.clock.sleep_until_ns(bus.clock.now_ns() + round(READ_PERIOD_S * 1e9))
    else:
        _refuse(bus, heard < heard.max(), "did not answer often enough: check its cable")
        raise BusError("answers are lost again and again: check cables with bigant servo watch")
    spread = np.ptp(np.array(ticks), axis=0)
    _refuse(bus, spread > LARGEST_SPREAD_TICKS, "moves: hold the shaft still and try again")
    medians = np.rint(np.median(np.array(ticks), axis=0)).astype(int) % TICKS_PER_TURN
    return [
        ServoZero(s.leg, s.servo_id, s.model, s.firmware, int(zero), int(wide))
        for s, zero, wide in zip(bus.report.servos, medians, spread, strict=True)
    ]


def _refuse(bus: "ServoBus", where: "BoolArray", why: str) -> None:
    import numpy as np

    places = np.flatnonzero(where)
    if len(places):
        legs = ", ".join(bus.settings.names[i] for i in places)
        raise BusError(f"{legs} {why}", ids=tuple(int(bus.settings.ids[i]) for i in places))


def zero_line(zeros: list[ServoZero]) -> str:
    """Return the line of the robot file."""
    return f"servo_zero = [{', '.join(str(zero.zero_ticks) for zero in zeros)}]"


def calibration_text(zeros: list[ServoZero], robot: str) -> str:
    """Return the calibration as TOML: which servo it was measured on stands beside each zero."""
    head = ("Shaft zeros; copy the line below into [legs] of the robot file", zero_line(zeros))
    kind = {"kind": "bigant servo zero", "version": 1, "robot": robot}
    date = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    servos = [
        {("id" if key == "servo_id" else key): value for key, value in asdict(zero).items()}
        for zero in zeros
    ]
    return toml_text({**kind, "date": date, "servo": servos}, head)
