"""Limits of ``[servo]`` that the data sheet of a model does not reach are warned of, by leg and model."""

import pytest

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106
from model.values.parameters import ServoParameters
from robot.config.robot_file import load_robot, parse_robot
from robot.config.xml import position_gain
from robot.design.review import review_robot, warning_lines
from robot.design.servo_concerns import servo_concerns
from tests.robot.other_servos import MIXED, XL330, XL430, other_robot

NAMES = ("HL", "FL")


def parameters(*models: str, **changes: float) -> ServoParameters:
    usual = {"supply_voltage": 12.0, "rated_torque_limit": 1.0, "max_speed": 3.0}
    return ServoParameters(**(usual | changes), max_acceleration=60.0, models=models)


def lines(servo: ServoParameters) -> list[str]:
    return [concern.line for concern in servo_concerns(servo, NAMES)]


def test_healthy_robots_raise_no_alarm() -> None:
    assert lines(parameters("MX-106(2.0)", "MX-106(2.0)")) == []
    for changes in ((), XL430, XL330):
        config = parse_robot(other_robot(*changes))
        assert not list(servo_concerns(config.parameters.servo, config.servo_bus.names))


def test_a_speed_above_the_no_load_speed_names_model_and_legs() -> None:
    assert lines(parameters("MX-106(2.0)", "XM540-W270", max_speed=4.0)) == [
        "servo.max_speed too fast: an XM540-W270 (FL) turns no faster than 3.14 rad/s at 12 V, without "
        "load; lower max_speed to 2.7 rad/s"
    ]


def test_both_go_with_the_voltage() -> None:
    assert lines(parameters("MX-106(2.0)", "MX-106(2.0)", max_speed=4.7)) == []
    slow = lines(parameters("MX-106(2.0)", "MX-106(2.0)", max_speed=4.7, supply_voltage=10.0))
    assert "an MX-106(2.0) (HL, FL) turns no faster than 3.93 rad/s at 10 V" in slow[0]
    weak = parameters("MX-106(2.0)", "MX-106(2.0)", rated_torque_limit=8.0, supply_voltage=11.0)
    assert "stalls at 7.7 N m at 11 V" in lines(weak)[0]


def test_it_is_among_the_warnings_of_a_robot_file() -> None:
    said = warning_lines(review_robot(parse_robot(other_robot(*MIXED))))
    assert sum("an XM540-W270 (FL) turns no faster than 3.14 rad/s" in line for line in said) == 1
    assert not [line for line in warning_lines(review_robot(load_robot())) if "servo" in line]


def test_the_gain_of_an_exported_motor_is_the_servos_own() -> None:
    assert position_gain(MX_106, 12.0) == 55.0
    xl430 = position_gain(MODEL_BY_NAME["XL430-W250"], 11.1)
    assert xl430 == pytest.approx(55.0 * 640 / 850 * 1.4 / 8.4)
