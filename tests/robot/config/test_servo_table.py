"""``[servo] model``: one for all or one a leg, and limits that the model can keep."""

import math

import pytest

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106, SERVO_MODELS
from model.errors import ConfigError
from robot.config.robot_file import parse_robot
from tests.robot.other_servos import MIXED, MIXED_MODELS, XL430, other_robot


def test_without_the_key_it_is_the_mx_106() -> None:
    config = parse_robot(other_robot())
    assert config.servo_bus.models == (MX_106,) * 6
    assert config.parameters.servo.models == ("MX-106(2.0)",) * 6


def test_one_name_is_for_all_legs() -> None:
    config = parse_robot(other_robot(*XL430))
    assert {model.name for model in config.servo_bus.models} == {"XL430-W250"}
    assert not config.servo_bus.measures_current.any()
    assert math.isinf(config.limits.max_current_a), "nobody measures it"


def test_a_list_has_one_a_leg() -> None:
    config = parse_robot(other_robot(*MIXED))
    assert tuple(model.name for model in config.servo_bus.models) == MIXED_MODELS
    assert config.servo_bus.measures_current.tolist() == [True, True, True, False, True, True]


@pytest.mark.parametrize("model", SERVO_MODELS, ids=lambda model: model.name)
def test_every_model_makes_a_robot_at_its_own_voltage(model) -> None:  # type: ignore[no-untyped-def]
    volts = model.ratings.voltage_v
    config = parse_robot(
        other_robot(
            ("supply_voltage = 12.0", f'model = "{model.name}"\nsupply_voltage = {volts}'),
            ("min_voltage = 10.0 ", f"min_voltage = {0.85 * volts} "),
            ("max_current = 4.0 ", "max_current = 0.5 "),
        )
    )
    assert config.servo_bus.models[0] is model


NAMED = ("supply_voltage = 12.0", 'model = "XM430-W350"\nsupply_voltage = 12.0')


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            [("supply_voltage = 12.0", 'model = "xl430-w205"\nsupply_voltage = 12.0')],
            r"servo\.model: 'xl430-w205' is no servo known here \(is 'XL430-W250' meant\?\); known are "
            r"MX-106\(2\.0\), .*; how to add one: docs/servos\.md",
        ),
        (
            [("supply_voltage = 12.0", 'model = ["XM430-W350"]\nsupply_voltage = 12.0')],
            r"servo\.model: must be one model, or a list with one a leg \(6\), not \['XM430-W350'\]",
        ),
        (
            [("supply_voltage = 12.0", "model = 1060\nsupply_voltage = 12.0")],
            r"servo\.model: must be one model, or a list with one a leg",
        ),
        (
            [("supply_voltage = 12.0", f"model = {[*MIXED_MODELS[:5], 7]}\nsupply_voltage = 12.0")],
            r"servo\.model\[5\]: 7 is no servo known here",
        ),
        (
            [NAMED, ("max_speed = 4.0 ", "max_speed = 25.0 ")],
            r"servo\.max_speed: must be at most 24\.52 rad/s, as far as an XM430-W350 goes, not 25",
        ),
        (
            [NAMED],
            r"servo\.max_current: must be at most 3\.209 A, as far as an XM430-W350 goes, not 4",
        ),
        (
            [("supply_voltage = 12.0", 'model = "XL330-M288"\nsupply_voltage = 12.0')],
            r"servo\.supply_voltage: must be 3\.1 to 7 V for an XL330-M288, not 12",
        ),
        (
            [("max_current = 4.0 ", "# ")],
            r"servo\.max_current: is missing",
        ),
        (
            [("supply_voltage = 12.0", 'model = "XL330-M288"\nsupply_voltage = 5.0'),
             ("min_voltage = 10.0 ", "min_voltage = 4.0 "), ("max_current = 4.0 ", "max_current = 1.0 "),
             ("baud_rate = 1000000", "baud_rate = 4500000")],
            r"servo_bus\.baud_rate: is more than an XL330-M288 can be set to \(4000000\)",
        ),
    ],
)  # fmt: skip
def test_what_a_model_cannot_do_is_refused_by_its_name(
    changes: list[tuple[str, str]], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_robot(other_robot(*changes))


def test_a_limit_on_currents_may_stand_where_none_is_measured() -> None:
    """It is not judged, and connecting says so."""
    changes = [change for change in XL430 if not change[0].startswith("max_current")]
    assert parse_robot(other_robot(*changes)).limits.max_current_a == 4.0
    assert MODEL_BY_NAME["XL430-W250"].measures_current is False
