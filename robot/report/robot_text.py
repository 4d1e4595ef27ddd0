"""A reviewed robot in words and tables: for a terminal, for a page, and as JSON."""

import math
from collections.abc import Sequence

import numpy as np

from robot.console.table import UNKNOWN, Column, row_lines, table_lines
from robot.design.assumed import assumed_keys
from robot.design.concern import Concern
from robot.design.gait_figures import GaitFigures
from robot.design.review import RobotReview
from robot.design.standing import STANDING

# What is worth saying of a robot that has no gait.
OF_STANDING = frozenset({
    "feet in stance", "static margin", "tilt over a cycle", "height, leg springs", "largest load",
    "joint torque", "torque, root mean square",
})  # fmt: skip


def review_lines(review: RobotReview, columns: int | None) -> list[str]:
    """Return the review as a terminal shows it.

    Args:
        review: The review.
        columns: Letters of a line; None: as long as it is.
    """
    figures = [one.figures for one in review.gaits]
    lines = row_lines(robot_rows(review), columns)
    if figures:
        heading = [Column(""), *(Column(one.gait, "s") for one in figures)]
        lines += ["", *table_lines(heading, figure_rows(review))]
    if review.concerns:
        lines += ["", *row_lines(concern_rows(review.concerns), columns)]
    lines += ["", *row_lines([("assumed", assumed_words(review))], columns)]
    return lines


def robot_rows(review: RobotReview) -> list[tuple[str, str]]:
    """Return what the robot is, without its gaits."""
    config = review.config
    robot = config.parameters
    shafts = robot.legs.shaft_position
    size = np.ptp(shafts, axis=0) * 1e3
    path = review.path_m
    feet = f"{-1e3 * path[..., 2].min():.0f} mm below the shafts"
    if robot.names.one_joint_a_leg:
        feet += (
            f"; a turn takes them over {1e3 * np.ptp(path[..., 0], axis=0).max():.0f} mm and up by "
            f"{1e3 * np.ptp(path[..., 2], axis=0).max():.0f} mm"
        )
    else:
        feet += ", all joints at zero"
    sensors = int(np.count_nonzero(config.force_sensor.transducers))
    return [
        ("robot", f"{config.name}, {robot.legs.count} legs: {', '.join(robot.legs.names)}"),
        ("body", f"{robot.body.mass:g} kg; shafts over {size[0]:.0f} x {size[1]:.0f} mm"),
        ("feet", feet),
        ("force sensors", f"{sensors}" if sensors else "none"),
    ]


def figure_rows(review: RobotReview) -> list[list[str]]:
    """Return each figure's label and its value for every gait."""
    servo = review.config.parameters.servo
    figures = [one.figures for one in review.gaits]
    rows = [
        ("cycles a second", [f"{one.frequency_hz:g} Hz" for one in figures]),
        ("speed", [_of(one.speed_m_s, 1e3, "mm/s") for one in figures]),
        ("turn at full steering", [_turn(one) for one in figures]),
        ("feet in stance", [_range(one.feet_least, one.feet_most) for one in figures]),
        ("static margin", [_margin(one) for one in figures]),
        ("tilt over a cycle", [_of(math.degrees(one.tilt_rad), 1, "deg") for one in figures]),
        ("height, leg springs", [_height(one) for one in figures]),
        ("lift of a swinging foot", [f"{_of(one.lift_m, 1e3, 'mm')} {one.lift_leg}" for one in figures]),
        ("largest load", [_of(one.load_share, 100, "% of weight") for one in figures]),
        ("on swinging feet", [_of(one.dragged_share, 100, "% of weight") for one in figures]),
        ("forced slip", [_of(one.forced_slip_m_s, 1e3, "mm/s") for one in figures]),
        ("slip over speed", [_slip(one) for one in figures]),
        ("shaft speed", [_limited(one.shaft_rad_s, servo.max_speed, "rad/s") for one in figures]),
        (
            "shaft acceleration",
            [_limited(one.shaft_rad_s2, servo.max_acceleration, "rad/s^2") for one in figures],
        ),
        (
            "joint torque",
            [_limited(one.torque_most_nm, servo.rated_torque_limit, "N m") for one in figures],
        ),
        ("torque, root mean square", [_of(one.torque_rms_nm, 1, "N m", 2) for one in figures]),
        ("rms over stall torque", [_of(one.stall_share, 100, "%", 0) for one in figures]),
        ("supply voltage used", [_of(one.duty_most, 100, "%", 0) for one in figures]),
    ]  # fmt: skip
    stands = all(one.gait == STANDING for one in figures)
    return [[label, *values] for label, values in rows if not stands or label in OF_STANDING]


def concern_rows(concerns: Sequence[Concern]) -> list[tuple[str, str]]:
    """Return each concern under its severity."""
    return [(one.severity.value, one.line) for one in concerns]


def assumed_words(review: RobotReview) -> str:
    """Return what the review takes for granted, and which keys of the file are marked as assumed."""
    words = (
        "level ground, massless legs, no motion of the body but the model's (quasi-static); friction and "
        "leg springs as in the file"
    )
    if review.config.effects:
        words += "; the file's effects are left out"
    keys = assumed_keys(review.config.text)
    return words + (f". Marked as assumed in the file: {', '.join(keys)}" if keys else "")


def review_json(review: RobotReview) -> dict[str, object]:
    """Return the review as JSON can hold it."""
    gaits = []
    for one in review.gaits:
        figures, cycle = one.figures, one.cycle
        gaits.append({
            "name": figures.gait,
            "figures": figures,
            "phase": cycle.phase,
            "stance": cycle.stance,
            "feet_B": cycle.feet.position_m,
            "load_n": cycle.answer.load_n,
            "margin_m": cycle.margin.margin_m,
            "velocity_B": cycle.answer.velocity_B,
            "forced_slip_m_s": cycle.forced.rms_m_s,
            "torque_nm": cycle.torque_nm,
        })  # fmt: skip
    return {
        "robot": review.config.name,
        "legs": review.config.parameters.legs.names,
        "gaits": gaits,
        "concerns": [
            {"severity": one.severity.value, "topic": one.topic, "place": one.place,
             "reason": one.reason, "advice": one.advice}
            for one in review.concerns
        ],
        "assumed": assumed_keys(review.config.text),
    }  # fmt: skip


def _of(value: float, factor: float, unit: str, digits: int = 1) -> str:
    if not math.isfinite(value):
        return UNKNOWN
    return f"{factor * value + 0.0:.{digits}f} {unit}"


def _turn(one: GaitFigures) -> str:
    if not math.isfinite(one.turn_rad_s):
        return UNKNOWN
    return f"{math.degrees(one.turn_rad_s):.2f} deg/s, {one.turn_radius_m:.2f} m radius"


def _range(least: int, most: int) -> str:
    return f"{least}" if least == most else f"{least} to {most}"


def _margin(one: GaitFigures) -> str:
    if not math.isfinite(one.margin_m):
        return UNKNOWN
    return f"{one.margin_m * 1e3:.0f} mm at phase {one.margin_phase:.2f}"


def _height(one: GaitFigures) -> str:
    return f"{_of(one.height_m, 1e3, 'mm', 0)}, pressed {_of(one.sink_m, 1e3, 'mm')}"


def _slip(one: GaitFigures) -> str:
    return _of(one.slip_share, 100, "%", 0)


def _limited(value: float, limit: float, unit: str) -> str:
    if not math.isfinite(limit):
        return _of(value, 1, unit, 2)
    if not math.isfinite(value):
        return f"unlimited of {limit:.3g} {unit}" if value > 0 else UNKNOWN
    return f"{value:.2f} of {limit:.3g} {unit}"
