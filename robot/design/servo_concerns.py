"""What is wrong with the limits of the servos: speeds and torques that their data sheets do not reach."""

from collections.abc import Iterator, Sequence

from model.values.parameters import ServoParameters
from robot.design.concern import Concern, warning
from robot.design.motors import motor_line

# Of the no-load speed; beyond it a servo has hardly any torque left. As in BigANT's robot file.
FAST_SHARE = 0.85


def servo_concerns(servo: ServoParameters, names: Sequence[str]) -> Iterator[Concern]:
    """Yield what a model of servo cannot do at the supply voltage, by its data sheet.

    Args:
        servo: Table ``[servo]`` of the robot file.
        names: Leg names.
    """
    line = motor_line(servo)
    for name in sorted(set(servo.models)):
        one = servo.models.index(name)
        speed, torque = line.no_load_rad_s[one], line.stall_nm[one]
        legs = ", ".join(leg for leg, its in zip(names, servo.models, strict=True) if its == name)
        if servo.max_speed > speed:
            yield warning(
                "too fast", "servo.max_speed",
                f"an {name} ({legs}) turns no faster than {speed:.3g} rad/s at {servo.supply_voltage:g} V, "
                f"without load", f"lower max_speed to {FAST_SHARE * speed:.2g} rad/s",
            )  # fmt: skip
        if servo.rated_torque_limit > torque:
            yield warning(
                "too strong", "servo.rated_torque_limit",
                f"an {name} ({legs}) stalls at {torque:.3g} N m at {servo.supply_voltage:g} V",
                "lower it; about a fifth of the stall torque lasts for more than a moment",
            )  # fmt: skip
