"""``bigant servo zero``: the position of every servo at shaft angle 0, for the robot file."""

import time
from contextlib import closing
from dataclasses import asdict, dataclass

import numpy as np

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.units import TICKS_PER_TURN
from model.errors import BusError, ConfigError
from model.values.arrays import BoolArray
from record.toml_file import toml_text
from robot.bringup.servo.access import bus_of, write_new
from robot.config.edit import with_servo_zeros
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.requests.servo import ServoZeroRequest

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


def zero(request: ServoZeroRequest) -> ExitCode:
    """Read and print.

    Raises:
        BusError: A servo does not answer, or a shaft moves.
        ConfigError: A file to be written exists or cannot be written.
    """
    config = load_robot(request.robot)
    for option, path in (("--write", request.write), ("--robot-out", request.robot_out)):
        if path is not None and path.exists():
            raise ConfigError(option, f"{path} exists; choose another name")
    with closing(bus_of(request.port, request.baud, config)) as bus:
        bus.connect()
        zeros = measure_zeros(bus)
    line = zero_line(zeros)
    lines = [
        *(
            f"{z.leg}  id {z.servo_id}  zero {z.zero_ticks}  spread {z.spread_ticks} ticks"
            for z in zeros
        ),
        f"for [legs] of the robot file:\n{line}",
    ]
    if request.write is not None:
        write_new(request.write, calibration_text(zeros, config.name), "--write")
        lines.append(f"kept in {request.write}")
    if request.robot_out is not None:
        text = with_servo_zeros(config.text, [one.zero_ticks for one in zeros])
        write_new(request.robot_out, text, "--robot-out")
        lines.append(f"robot file with these zeros: {request.robot_out}")
    print_result({"servos": zeros, "line": line}, lines, as_json=request.json)
    return ExitCode.OK


def measure_zeros(bus: ServoBus) -> list[ServoZero]:
    """Return the median position of every servo.

    Args:
        bus: The bus, connected.

    Raises:
        BusError: A servo does not answer often enough, or a shaft moves.
    """
    ticks, answers = [], np.zeros(len(bus.settings.names), dtype=int)
    for _ in range(TRIES):
        readings = bus.read()
        answers += readings.valid
        if readings.valid.all():
            ticks.append(readings.position_ticks)
            if len(ticks) == READS:
                break
        bus.clock.sleep_until_ns(bus.clock.now_ns() + round(READ_PERIOD_S * 1e9))
    else:
        _refuse(bus, answers < answers.max(), "did not answer often enough: check its cable")
        raise BusError("answers are lost again and again: check cables with bigant servo watch")
    spread = np.ptp(np.array(ticks), axis=0)
    _refuse(bus, spread > LARGEST_SPREAD_TICKS, "moves: hold the shaft still and try again")
    medians = np.rint(np.median(np.array(ticks), axis=0)).astype(int) % TICKS_PER_TURN
    return [
        ServoZero(s.leg, s.servo_id, s.model, s.firmware, int(middle), int(wide))
        for s, middle, wide in zip(bus.report.servos, medians, spread, strict=True)
    ]


def _refuse(bus: ServoBus, where: BoolArray, why: str) -> None:
    places = np.flatnonzero(where)
    if len(places):
        legs = ", ".join(bus.settings.names[i] for i in places)
        raise BusError(f"{legs} {why}", ids=tuple(int(bus.settings.ids[i]) for i in places))


def zero_line(zeros: list[ServoZero]) -> str:
    """Return the line of the robot file."""
    return f"servo_zero = [{', '.join(str(one.zero_ticks) for one in zeros)}]"


def calibration_text(zeros: list[ServoZero], robot: str) -> str:
    """Return the zeros as TOML, each with the servo that it was measured on."""
    document = {
        "kind": "bigant servo zero",
        "version": 1,
        "robot": robot,
        "date": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "servo": [
            {name.removeprefix("servo_"): value for name, value in asdict(one).items()}
            for one in zeros
        ],
    }
    head = "Shaft zeros; copy the line below into [legs] of the robot file"
    return toml_text(document, (head, zero_line(zeros)))
