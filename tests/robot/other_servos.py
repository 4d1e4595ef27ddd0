"""Robot files of hexapods with other servos than BigANT's, for tests."""

from robot.console.arguments import DEFAULT_ROBOT_FILE

XL430 = (
    ("mass = 6.5 ", "mass = 1.8 "),
    ("supply_voltage = 12.0", 'model = "XL430-W250"\nsupply_voltage = 11.1'),
    ("rated_torque_limit = 4.0 ", "rated_torque_limit = 0.7 "),
    ("max_temperature = 70.0 ", "max_temperature = 65.0 "),
    ("min_voltage = 10.0 ", "min_voltage = 9.0 "),
    ("max_current = 4.0 ", "# "),
)
XL330 = (
    ("mass = 6.5 ", "mass = 0.6 "),
    ("supply_voltage = 12.0", 'model = "XL330-M288"\nsupply_voltage = 5.0'),
    ("rated_torque_limit = 4.0 ", "rated_torque_limit = 0.25 "),
    ("max_temperature = 70.0 ", "max_temperature = 60.0 "),
    ("min_voltage = 10.0 ", "min_voltage = 4.2 "),
    ("max_current = 4.0 ", "max_current = 1.2 "),
)
MIXED_MODELS = (
    "XM430-W350", "MX-106(2.0)", "XM540-W270", "XC430-W240", "MX-64(2.0)", "XH540-W270",
)  # fmt: skip
MIXED = (
    ("mass = 6.5 ", "mass = 2.5 "),
    ("supply_voltage = 12.0", f"model = {list(MIXED_MODELS)}\nsupply_voltage = 12.0"),
    ("max_current = 4.0 ", "max_current = 3.0 "),
)


def other_robot(*changes: tuple[str, str]) -> str:
    """Return the text of BigANT's robot file with changes."""
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text
