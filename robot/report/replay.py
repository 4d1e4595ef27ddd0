"""The 3-D replay of a log for a page: legs, body, forces and path as arrays for ``templates/replay.js``.

Of a long log only some ticks are kept; between them the script goes straight.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from model.errors import BigantError
from model.kinematics.legs import leg_kinematics
from model.motion.se2 import quaternion_of, yaw_of
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.parameters import RobotParameters
from model.values.tick import Mode
from record.log.recording import Recording
from robot.config.robot_file import parse_robot
from robot.report.ground_truth import aligned_to_truth
from robot.report.packed import packed_floats, packed_text, packed_whole, script_json
from robot.report.page import PagePicture
from robot.report.replay_still import still_of
from robot.report.scene import (
    FULL_SLIP_M_S,
    LEAST_FORCE_N,
    METRES_PER_NEWTON,
    SHOWN_SLIP_M_S,
    body_of,
    leg_links,
)

MOST_FRAMES = 2400
LEAST_STEP_S = 0.04  # 25 frames a second
NAME = "Replay"
SAYS = (
    "Blue arrows are measured foot forces, orange ones those that the model predicts. The path of a foot "
    "on the ground is grey where it holds and red where it slips. Squares of the ground are 0.1 m wide."
)


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLinks:
    """The lines that all legs consist of, in F frames.

    Attributes:
        strips: Of each line: its leg, its first point and how many points it has.
        points: Of all lines, (F, P, 3) [m], body frame.
    """

    strips: list[list[int]]
    points: FloatArray


def drawn_links(parameters: RobotParameters, angles_rad: FloatArray) -> DrawnLinks:
    """Return the lines of all legs at the angles of all joints, (F, J)."""
    points: list[FloatArray] = []
    strips: list[list[int]] = []
    for leg in range(parameters.legs.count):
        for link in leg_links(parameters, leg, angles_rad):
            strips.append([leg, sum(one.shape[1] for one in points), link.points.shape[1]])
            points.append(link.points)
    return DrawnLinks(strips, np.concatenate(points, axis=1))


def replay_of(log: Recording) -> PagePicture | None:
    """Return the replay of a log; None where its robot file or its angles are not known."""
    parameters = _drawn_robot(log)
    if parameters is None:
        return None
    arrays = _arrays(log, parameters, kept_frames(log.t_s))
    text = script_json(packed_frames(arrays))
    return PagePicture(NAME, still_of(arrays), text, SAYS, kind="replay")


def replay_frames(log: Recording, rows: IntArray) -> dict[str, Any] | None:
    """Return some ticks of a log as ``templates/replay.js`` takes them; None where no robot is known."""
    parameters = _drawn_robot(log)
    return None if parameters is None else packed_frames(_arrays(log, parameters, rows))


def _drawn_robot(log: Recording) -> RobotParameters | None:
    """The robot of a log's own file, if its legs are those of the log and some angles are known."""
    try:
        parameters = parse_robot(log.config_text).parameters
    except BigantError:
        return None  # a log of another program's robot: there is nothing to draw
    known = parameters.legs.names == log.names and np.isfinite(log.angle_rad).all(axis=1).any()
    return parameters if known else None


def kept_frames(t_s: FloatArray) -> IntArray:
    """Return which of T ticks are kept: one every 0.04 s, and at most 2400."""
    span_s = float(t_s[-1] - t_s[0])
    count = int(min(len(t_s), MOST_FRAMES, max(2.0, span_s / LEAST_STEP_S + 1)))
    at_s = np.linspace(t_s[0], t_s[-1], count)
    return np.unique(np.searchsorted(t_s, at_s).clip(0, len(t_s) - 1))


def _arrays(log: Recording, parameters: RobotParameters, rows: IntArray) -> dict[str, Any]:
    """What is drawn in F frames, with NaN for what is not known."""
    angles = log.angle_rad[rows]
    known: BoolArray = np.asarray(np.isfinite(angles).all(axis=1))
    angles = np.where(known[:, None], angles, 0.0)
    feet = leg_kinematics(parameters).feet(angles, np.zeros_like(angles)).position_m
    links = drawn_links(parameters, angles)
    body = body_of(parameters)
    loaded, slip = _slip(log, rows)
    place, turn, paths = _motion(log, rows, feet, loaded)
    return {
        "names": list(log.names),
        "begin": float(log.t_s[np.argmax(log.mode == Mode.WALK.value)]),
        "t": log.t_s[rows],
        "place": place,
        "turn": turn,
        "strips": links.strips,
        "points": np.where(known[:, None, None], links.points, np.nan),
        "feet": np.where(known[:, None, None], feet, np.nan),
        "loaded": loaded,
        "slip": slip,
        "red_from_to": [SHOWN_SLIP_M_S, FULL_SLIP_M_S],
        "measured": log.force_n[rows],
        "predicted": log.predicted_force_n[rows],
        "paths": paths,
        "box": [*body.centre.tolist(), *body.size.tolist()],
        "metres_per_newton": METRES_PER_NEWTON,
        "least_n": LEAST_FORCE_N,
    }


def _slip(log: Recording, rows: IntArray) -> tuple[BoolArray, FloatArray]:
    """Which feet are loaded, and how fast they slip [m/s], (F, N): true where known, else the model's."""
    velocity = log.truth_foot_velocity_W[rows, :, :2]
    predicted = log.predicted_slip_B[rows]
    with_truth: BoolArray = np.asarray(np.isfinite(velocity).all(axis=2))
    true = with_truth.any(axis=1, keepdims=True)
    loaded = np.where(true, log.truth_contact[rows], np.isfinite(predicted).all(axis=2))
    slip = np.where(true, np.linalg.norm(velocity, axis=2), np.linalg.norm(predicted, axis=2))
    return loaded, np.where(loaded, slip, np.nan)


def _motion(
    log: Recording, rows: IntArray, feet: FloatArray, loaded: BoolArray
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Place (F, 3), attitude (F, 4) of the body, and each path seen from above, (F, 2), by name.

    Ground truth if available, then the estimator, then dead reckoning.
    """
    reckoned = aligned_to_truth(log, log.dead_reckoning_pose)[rows]
    estimated = aligned_to_truth(log, log.estimate_pose)[rows]
    pose = np.where(_known(estimated), estimated, reckoned)
    place, turn = (
        np.column_stack([pose[:, :2], np.full(len(rows), np.nan)]),
        quaternion_of(pose[:, 2]),
    )
    true, attitude = log.truth_position_W[rows], log.truth_quaternion_xyzw[rows]
    place = np.where(_known(true[:, :2]), true, place)
    yaw = yaw_of(attitude)
    turn = np.where(_known(yaw[:, None]), quaternion_of(yaw), turn)
    turn = np.where(_known(attitude), attitude, turn)
    air = ~loaded & loaded.any(axis=1, keepdims=True)
    standing = np.where(air, np.inf, feet[..., 2])
    lowest = standing.min(axis=1)
    place[:, 2] = np.where(np.isfinite(place[:, 2]), place[:, 2], -lowest)
    paths = {"true": true[:, :2], "estimator": estimated[:, :2], "dead reckoning": reckoned[:, :2]}
    return place, turn, {name: one for name, one in paths.items() if np.isfinite(one).any()}


def _known(values: FloatArray) -> BoolArray:
    """Which rows are known, (F, 1)."""
    return np.asarray(np.isfinite(values).all(axis=1, keepdims=True))


def packed_frames(arrays: dict[str, Any]) -> dict[str, Any]:
    """Return arrays as text: whole numbers times a scale where a ten-thousandth of the range is enough."""
    packed: dict[str, Any] = {}
    for name, value in arrays.items():
        if name == "paths":
            packed[name] = {one: packed_floats(path) for one, path in value.items()}
        elif name in {"t", "place", "turn"}:
            packed[name] = packed_floats(value)
        elif name == "loaded":
            packed[name] = packed_text(value, np.uint8)
        elif isinstance(value, np.ndarray):
            packed[name] = packed_whole(value)
        else:
            packed[name] = value
    return packed
