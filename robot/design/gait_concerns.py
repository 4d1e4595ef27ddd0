"""What is wrong with a gait's figures: it tips, drags, rocks, saturates, slips; each with a remedy."""

import math
from collections.abc import Iterator

from model.values.arrays import FloatArray
from model.values.parameters import ServoParameters
from robot.design.concern import Concern, Severity, impossible, note, warning
from robot.design.gait_figures import GaitFigures

LEAST_FEET = 3  # a polygon
# A margin smaller than this share of what the same gait has with its shafts moved is a mistake of places.
MARGIN_SHARE = 0.25
EDGE = 0.002  # of the feet's span: so near to tipping in any case
WORTH_MOVING_M = 0.002
DRAGGED_SHARE = 0.03  # of the weight
IDLE_SHARE = 0.5  # of a leg's stance
TILT_SHARE = 0.25  # of safety.max_tilt
LEAST_LIFT = 0.01  # of the body's height
HARDLY = 0.05  # of the speed of the feet
LASTING_SHARE = 0.2  # of the stall torque: ROBOTIS e-manual, "performance graph"
SLIDING, SLIPPING = 1.0, 0.3  # slip of the feet over the body's speed


def gait_concerns(
    one: GaitFigures, servo: ServoParameters, max_tilt_rad: float
) -> Iterator[Concern]:
    """Yield what is wrong with a gait, what matters most first.

    Args:
        one: Its figures.
        servo: What the servos can do.
        max_tilt_rad: At which the robot stops.
    """
    balance = list(_balance(one))
    yield from balance
    if any(concern.severity is Severity.IMPOSSIBLE for concern in balance):
        return
    if one.unsolved > 0:
        yield warning(
            "no balance",
            one.gait,
            f"in {100 * one.unsolved:.0f} % of the cycle the model finds no balance of the leg springs",
            "check contact.stiffness against body.mass, and places that coincide",
        )
    yield from _feet(one)
    if one.tilt_rad > TILT_SHARE * max_tilt_rad:
        yield warning(
            "rocks",
            one.gait,
            f"the body tilts to and fro by {math.degrees(one.tilt_rad):.1f} deg in a cycle; the robot "
            f"stops at {math.degrees(max_tilt_rad):.0f} deg (safety.max_tilt)",
            "stiffen contact.stiffness, spread the feet, or let more of them stand at a time",
        )
    yield from _walking(one)
    yield from _servos(one, servo)


def _balance(one: GaitFigures) -> Iterator[Concern]:
    if one.falls >= 1:
        yield impossible(
            "falls", one.gait, "the centre of mass is above none of the feet, standing or swinging: the "
            "robot falls over", _moving(one),
        )  # fmt: skip
        return
    if one.feet_least < LEAST_FEET:
        feet = {0: "no foot is", 1: "only one foot is", 2: "only two feet are"}[one.feet_least]
        yield warning(
            "leaps" if one.feet_least == 0 else "too few feet",
            one.gait,
            f"at some phases {feet} in stance: a robot that walks slowly stands on three",
            "raise the duty, or change phases or groups so that three feet always stand",
        )
    at = f"at phase {one.margin_phase:.2f}"
    margin = f"{abs(one.margin_m) * 1e3:.0f} mm"
    if one.falls > 0:
        yield warning(
            "tips", one.gait,
            f"in {100 * one.falls:.0f} % of the cycle the centre of mass is above no foot at all and the "
            "robot falls over", _moving(one),
        )  # fmt: skip
    elif one.margin_m < 0 and one.feet_least > 0:
        yield warning(
            "tips", one.gait,
            f"{at} the centre of mass lies {margin} outside the feet in stance, {_where(-one.margin_B)}: "
            "it tips until a swinging foot catches it", _moving(one),
        )  # fmt: skip
    elif one.feet_least >= LEAST_FEET and (
        one.margin_m < EDGE * one.span_m
        or (
            one.margin_m < MARGIN_SHARE * one.centred.margin_m
            and one.centred.margin_m - one.margin_m > WORTH_MOVING_M
        )
    ):
        yield warning(
            "near tipping", one.gait,
            f"{at} the centre of mass is {margin} from the edge of the feet in stance, "
            f"{_where(one.margin_B)}", _moving(one),
        )  # fmt: skip


def _where(towards: FloatArray) -> str:
    """Return in which direction of the body a vector points."""
    x, y = float(towards[0]), float(towards[1])
    if abs(x) >= abs(y):
        return "ahead" if x > 0 else "behind"
    return "to the left" if y > 0 else "to the right"


def _moving(one: GaitFigures) -> str:
    """Return by how much to move what."""
    x, y = (1e3 * float(part) for part in one.centred.shift_m)
    if one.centred.margin_m < WORTH_MOVING_M:
        return "no place of the shafts helps: let more feet stand at a time"
    shifts = [f"{mm:+.0f} mm in {axis}" for mm, axis in ((x, "x"), (y, "y")) if abs(mm) >= 1]
    if not shifts:
        return "let more feet stand at a time, or shorten the sweep"
    words = " and ".join(shifts)
    back = " and ".join(
        f"{-mm:+.0f} mm in {axis}" for mm, axis in ((x, "x"), (y, "y")) if abs(mm) >= 1
    )
    return (
        f"move the shafts by {words} (legs.shaft_position) or the centre of mass by {back}: the margin is "
        f"then {one.centred.margin_m * 1e3:.0f} mm"
    )


def _feet(one: GaitFigures) -> Iterator[Concern]:
    if one.height_m < 0:
        yield warning(
            "upside down", one.gait,
            f"the feet stand {abs(one.height_m) * 1e3:.0f} mm above the body frame",
            "z points up: check the signs of the leg's z, its branch and mid_stance",
        )  # fmt: skip
        return
    if one.dragged_share > DRAGGED_SHARE:
        yield warning(
            "drags", one.gait,
            f"feet in the middle of their swing carry up to {100 * one.dragged_share:.0f} % of the weight "
            f"(most of it {one.dragged_leg})",
            "change duty and sweep so that a foot is down only in stance, move the centre of mass, or "
            "stiffen contact.stiffness",
        )  # fmt: skip
    elif one.lift_m < LEAST_LIFT * abs(one.height_m):
        yield warning(
            "hardly lifts", one.gait,
            f"foot {one.lift_leg} comes no higher than {one.lift_m * 1e3:.1f} mm in its swing, and would "
            "catch on any unevenness", "lengthen what lifts it (crank, radius, sweep)",
        )  # fmt: skip
    if one.idle_share > IDLE_SHARE:
        yield warning(
            "hangs", one.gait,
            f"leg {one.idle_leg} carries nothing in {100 * one.idle_share:.0f} % of its stance",
            "check mid_stance, offset and shaft_position of that leg: its foot is down at another angle",
        )  # fmt: skip


def _walking(one: GaitFigures) -> Iterator[Concern]:
    speed_mm_s = one.speed_m_s * 1e3
    if not math.isfinite(one.speed_m_s):
        return
    if one.speed_m_s < -HARDLY * one.slip_m_s:
        yield warning(
            "walks backward", one.gait, f"it walks at {speed_mm_s:.1f} mm/s",
            "an increasing shaft angle has to move a standing foot backward: check the leg's branch and "
            "mid_stance, and x forward",
        )  # fmt: skip
    elif one.slip_share > SLIDING:
        yield warning(
            "slides", one.gait,
            f"its feet slide {_times(one.slip_share)} as far as the body walks",
            "feet that stand together must move alike: make their speed even, or shorten the sweep",
        )  # fmt: skip
    elif one.slip_share > SLIPPING:
        yield note(
            "slips", one.gait,
            f"its feet slip {100 * one.slip_share:.0f} % as far as the body walks: the gait forces it",
        )  # fmt: skip


def _times(share: float) -> str:
    return f"{share:.1f} times" if share < 100 else "more than 100 times"


def _servos(one: GaitFigures, servo: ServoParameters) -> Iterator[Concern]:
    if one.shaft_rad_s > servo.max_speed:
        yield warning(
            "saturates", one.gait,
            f"shafts need {one.shaft_rad_s:.3g} rad/s, servo.max_speed is {servo.max_speed:.3g} rad/s",
            f"lower the frequency to {one.frequency_hz * servo.max_speed / one.shaft_rad_s:.3g} Hz",
        )  # fmt: skip
    if one.shaft_rad_s2 > servo.max_acceleration:
        yield warning(
            "saturates", one.gait,
            f"shafts need {one.shaft_rad_s2:.3g} rad/s^2, servo.max_acceleration is "
            f"{servo.max_acceleration:.3g} rad/s^2", "lower the frequency, or round the gait's corners",
        )  # fmt: skip
    if one.torque_most_nm > servo.rated_torque_limit:
        yield warning(
            "saturates", one.gait,
            f"{one.torque_joint} needs up to {one.torque_most_nm:.3g} N m, servo.rated_torque_limit is "
            f"{servo.rated_torque_limit:.3g} N m",
            "lighten the body, shorten the legs, or choose stronger servos",
        )  # fmt: skip
    if one.duty_most > 1:
        yield warning(
            "saturates", one.gait,
            f"a servo needs {100 * one.duty_most:.0f} % of the supply voltage for its torque at its speed",
            "lower the frequency, raise servo.supply_voltage, or choose other servos",
        )  # fmt: skip
    if one.stall_share > LASTING_SHARE:
        yield warning(
            "heats", one.gait,
            f"the mean torque of a servo (root mean square) is {100 * one.stall_share:.0f} % of its stall "
            "torque; servos of this kind last at up to 20 %",
            "lighten the body, shorten the legs, or choose stronger servos",
        )  # fmt: skip
