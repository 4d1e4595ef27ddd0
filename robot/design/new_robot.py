"""``bigant robot new``: a first robot file, from options or from answers on a terminal."""

import re
import sys
from argparse import ArgumentTypeError
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106
from drivers.dynamixel.servo_model import ServoModel
from model.errors import BigantError, ConfigError
from record.whole_file import check_room, write_text
from robot.config.robot_file import parse_robot
from robot.console.arguments import between
from robot.console.exit_codes import ExitCode
from robot.console.printable import printable
from robot.design.new_text import CRANK, FOUR_BAR, NewRobot, robot_text
from robot.design.review import review_robot
from robot.requests.robot import LEAST_LEGS, MOST_LEGS, RobotNewRequest

Value = TypeVar("Value")
SMALLEST_M, LARGEST_M = 0.005, 5.0
LIGHTEST_KG, HEAVIEST_KG = 0.02, 200.0
# A robot that suits the MX-106; another servo carries one whose weight times leg grows with its torque.
DEPTH_M, ACROSS_M, MASS_KG = 0.13, 0.5, 6.5
CRANK_SHARE = 0.7  # a wheel-leg has its whole length as a lever


def new_robot(request: RobotNewRequest) -> ExitCode:
    """Write a robot file, and say how its robot walks.

    Returns:
        OK, or VERDICT_FAILED where the model warns of the robot as it is.

    Raises:
        ConfigError: There is no such servo, or the values make no robot.
        RecordError: The file cannot be written.
    """
    check_room(request.out, "--out", ".toml")
    new = _answers(request)
    out = request.out or Path(
        f"{re.sub(r'[^a-z0-9]+', '-', new.name.lower()).strip('-') or 'robot'}.toml"
    )
    text = robot_text(new)
    review = review_robot(parse_robot(text))
    write_text(out, text)
    gaits = ", ".join(
        f"{one.figures.gait} {one.figures.speed_m_s * 1e3:.0f} mm/s" for one in review.gaits
    )
    print(f"{out}: {new.legs} legs, {new.servo.name}, {new.mass_kg:g} kg; {gaits}")
    for one in review.warnings:
        print(printable(f"warning: {one.line}"))
    print(f"look at it:  bigant robot show {out} --out {out.with_suffix('.html')}")
    print(f"walk it:     bigant drive --robot {out} --virtual-time")
    return ExitCode.VERDICT_FAILED if review.warnings else ExitCode.OK


def _answers(request: RobotNewRequest) -> NewRobot:
    """Take each value from its option, else from a person at a terminal, else as it usually is."""
    name = _value(request.name, "name of the robot", "Robot", _text)
    legs = _value(request.legs, "number of legs", 6, between(LEAST_LEGS, MOST_LEGS, whole=True))
    leg = _value(request.leg, f"kind of leg, {FOUR_BAR} or {CRANK}", FOUR_BAR, _leg)
    servo = _servo(_value(request.servo, "model of the servos", MX_106.name, _servo_name))
    size = (servo.ratings.stall_torque_n_m / MX_106.ratings.stall_torque_n_m) ** (1 / 3)
    metres = between(SMALLEST_M, LARGEST_M, "m")
    usual = {"leg_length": _short(DEPTH_M * size * (CRANK_SHARE if leg == CRANK else 1.0))}
    leg_length = _value(request.leg_length, "foot below shaft [m]", usual["leg_length"], metres)
    # neighbours must not meet: rows of feet are one and a half legs apart
    usual["length"] = _short(1.5 * leg_length * (max(2, (legs + 1) // 2) - 1))
    length = _value(request.length, "hind feet to front feet [m]", usual["length"], metres)
    usual["width"] = _short(ACROSS_M * size)
    width = _value(request.width, "left feet to right feet [m]", usual["width"], metres)
    usual["mass"] = _short(MASS_KG * size**2)
    kilograms = between(LIGHTEST_KG, HEAVIEST_KG, "kg")
    mass = _value(request.mass, "mass of all of it [kg]", usual["mass"], kilograms)
    sensors = _value(request.force_sensors, "force sensors, none or ati", "none", _sensors)
    sizes = {"leg_length": leg_length, "length": length, "width": width, "mass": mass}
    return NewRobot(
        name=name, legs=legs, leg=leg, servo=servo, leg_length_m=leg_length, length_m=length,
        width_m=width, mass_kg=mass, force_sensors=sensors == "ati",
        given=frozenset(
            one for one in sizes if sizes[one] != usual[one] or getattr(request, one) is not None
        ),
    )  # fmt: skip


def _value(given: Value | None, question: str, usual: Value, read: Callable[[str], Value]) -> Value:
    """Return what was given; else the answer of a person, who may press return for what is usual."""
    if given is not None:
        return given
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return usual
    while True:
        try:
            answer = input(f"{question} ({usual}): ").strip()
        except EOFError:  # the terminal went away
            raise KeyboardInterrupt from None
        if not answer:
            return usual
        try:
            return read(answer)
        except (ValueError, ArgumentTypeError, BigantError) as error:
            print(f"  {printable(str(error))}")


def _text(answer: str) -> str:
    return answer


def _word(answer: str, known: tuple[str, ...]) -> str:
    if answer not in known:
        raise ValueError(f"must be {' or '.join(known)}, not {answer}")
    return answer


def _leg(answer: str) -> str:
    return _word(answer, (FOUR_BAR, CRANK))


def _sensors(answer: str) -> str:
    return _word(answer, ("none", "ati"))


def _servo_name(answer: str) -> str:
    return _servo(answer).name


def _servo(name: str) -> ServoModel:
    if name not in MODEL_BY_NAME:
        raise ConfigError(
            "--servo", f"{name!r} is no servo known here; known are {', '.join(MODEL_BY_NAME)}"
        )
    return MODEL_BY_NAME[name]


def _short(value: float) -> float:
    return float(f"{value:.2g}")
