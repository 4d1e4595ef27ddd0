"""The robot file: what cannot be is refused, by key and with a reason."""

from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError
from model.values.parameters import FourBarParameters
from robot.config.robot_file import load_robot, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE

NOMINAL = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")


def changed(old: str, new: str) -> str:
    assert NOMINAL.count(old) == 1, f"{old!r} must stand once in the robot file"
    return NOMINAL.replace(old, new)


def test_the_nominal_file_loads() -> None:
    config = load_robot()
    assert config.name == "BigANT"
    assert config.parameters.legs.names == ("HL", "ML", "FL", "HR", "MR", "FR")
    assert config.parameters.body.mass == 6.5
    assert config.servo_bus.ids.tolist() == [1, 2, 3, 4, 5, 6]
    assert config.text == NOMINAL


def test_every_assumed_value_is_marked() -> None:
    assert NOMINAL.count("assumed") >= 20


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = 6.5 ", "mass = -6.5 ", r"body\.mass: must be above 0"),
        ("mass = 6.5 ", "mass = nan ", r"body\.mass: must be finite"),
        ("mass = 6.5 ", "weight = 6.5 ", r"body\.mass: is missing"),
        ('["HL", "ML", ', '["hind left", "ML", ', r"legs\.order: 'hind left' is no name of a leg"),
        ('["HL", "ML", ', '["legs/HL", "ML", ', r"legs\.order: 'legs/HL' is no name of a leg"),
        ("mass = 6.5 ", "mass = 6.5\nmas = 1 ", r"body\.mas: is not a known key"),
        ("[0.10, 0.14, 0.22]", "[0.10, 0.14, 0.30]", r"body\.inertia: no rigid body"),
        (
            "dynamixel_id = [1, 2, 3, 4, 5, 6]",
            "dynamixel_id = [1, 2, 3, 4, 5, 5]",
            r"share id 5 \(legs MR, FR\)",
        ),
        ("dynamixel_id = [1, 2, 3, 4, 5, 6]", "dynamixel_id = [1, 2, 3]", "must have 6 entries"),
        ("dynamixel_id = [1, 2, 3, 4, 5, 6]", "dynamixel_id = [1, 2, 3, 4, 5, 254]", "0 to 252"),
        (
            "transducer = [1, 2, 3, 4, 5, 6]",
            "transducer = [1, 2, 3, 4, 6, 6]",
            r"share transducer 6 \(legs MR, FR\)",
        ),
        ("servo_sign = [1, 1, 1, -1, -1, -1]", "servo_sign = [1, 1, 0, -1, -1, -1]", "1 or -1"),
        ("crank = 0.030", "crank = 0.300", r"leg\."),
        ("rocker = 0.044", "rocker = 0.004", r"leg\."),
        ("branch = 1 ", "branch = 0 ", r"leg\.branch: must be 1 or -1"),
        ("watchdog = 0.24 ", "watchdog = 0.25 ", "multiple of 0.02"),
        ("watchdog = 0.24 ", "watchdog = 0.02 ", "less than three periods"),
        ("oversampling = 32", "oversampling = 32\nx = 1", r"force_sensor\.x: is not a known key"),
        ("oversampling = 32", "oversampling = 32.5", "must be a whole number"),
        ("udp_port = 49152", "udp_port = 70000", "from 1 to 65535"),
        ("rate = 100                       # packets", "rate = 400 # packets", "at most 4000"),
        ('group_a = ["HL", "FL", "MR"]', 'group_a = ["HL", "FL", "XX"]', "'XX' is no leg"),
        ("cubic = 0.8 ", "cubic = 1.8 ", r"gait\.metachronal\.cubic: must be at most 1"),
        ('name = "BigANT"', "name = 3", "must be a non-empty text"),
        ("[loop]", "[loop", "is not valid TOML"),
    ],
)
def test_what_cannot_be_is_refused_by_key(old: str, new: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_robot(changed(old, new))


def test_unreadable_file_names_the_path(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.toml: the robot file cannot be read: No such"):
        load_robot(tmp_path / "none.toml")


def test_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="not UTF-8"):
        load_robot(path)


def test_another_robot_loads(tmp_path: Path) -> None:
    path = tmp_path / "light.toml"
    path.write_text(changed("mass = 6.5 ", "mass = 4.0 "), encoding="utf-8")
    assert load_robot(path).parameters.body.mass == 4.0


def test_values_are_read_only() -> None:
    stiffness = load_robot().parameters.contact.stiffness
    with pytest.raises(ValueError, match="read-only"):
        stiffness[0] = np.nan


OLD_LEG_TABLE = NOMINAL.replace("[leg] ", "[linkage] ").replace('kind = "four_bar"', "#")


def test_a_robot_file_from_before_other_legs_is_still_read() -> None:
    old, new = parse_robot(OLD_LEG_TABLE).parameters.leg, parse_robot(NOMINAL).parameters.leg
    assert isinstance(old, FourBarParameters)
    assert isinstance(new, FourBarParameters)
    for name in ("crank", "coupler", "rocker", "branch", "mid_stance"):
        assert getattr(old, name) == getattr(new, name)
    np.testing.assert_array_equal(old.foot, new.foot)
    with pytest.raises(ConfigError, match=r"linkage\.crank: the linkage cannot turn"):
        parse_robot(OLD_LEG_TABLE.replace("crank = 0.030", "crank = 0.300"))


def test_a_robot_has_one_geometry_of_its_legs_and_of_a_known_kind() -> None:
    with pytest.raises(ConfigError, match="linkage: is not a known key"):
        parse_robot(NOMINAL + "\n[linkage]\ncrank = 0.03\n")
    with pytest.raises(ConfigError, match=r"leg\.kind: must be one of four_bar.*'wing'"):
        parse_robot(NOMINAL.replace('"four_bar"', '"wing"'))
    with pytest.raises(ConfigError, match=r"leg\.kind: is missing"):
        parse_robot(NOMINAL.replace('kind = "four_bar"', "#"))


@pytest.mark.parametrize(
    ("old", "new", "degrees"),
    [
        ("stance_sweep = 1.2 ", "stance_sweep = 3.2 ", 97),
        ("offset = -0.1 ", "offset = -1.1 ", 97),
    ],
)
def test_a_crank_cannot_stand_level_or_up(old: str, new: str, degrees: int) -> None:
    wheel = DEFAULT_ROBOT_FILE.parents[1] / "examples" / "wheel_hexapod.toml"
    text = wheel.read_text(encoding="utf-8")
    assert old in text
    words = rf"gait\.tripod\.stance_sweep: turns HL to {degrees} deg from straight down in stance"
    with pytest.raises(ConfigError, match=words):
        parse_robot(text.replace(old, new))
