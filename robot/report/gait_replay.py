"""One cycle of a gait as the model walks it, in three dimensions; ``bigant robot show`` begins with it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from model.motion.se2 import compose, exponential
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import RobotParameters
from robot.design.gait_figures import WalkedGait
from robot.design.review import RobotReview
from robot.design.standing import STANDING
from robot.report.packed import script_json
from robot.report.page import PagePicture, Section
from robot.report.pictures import pictures
from robot.report.replay import drawn_links, packed_frames
from robot.report.replay_still import still_of
from robot.report.scene import (
    FULL_SLIP_M_S,
    LEAST_FORCE_N,
    METRES_PER_NEWTON,
    SHOWN_SLIP_M_S,
    body_of,
)

WALKS = (
    "One cycle of {gait} as the model walks it: slide or play, drag to turn it. Orange arrows are the "
    "ground's forces on the feet. The path of a foot on the ground is grey where it holds and red where it "
    "slips. Squares of the ground are 0.1 m wide."
)
STANDS = "All joints at zero. Orange arrows are the ground's forces on the feet."


def gait_replay(robot: RobotParameters, one: WalkedGait) -> PagePicture:
    """Return a gait's cycle as a replay; the slider moves through its phases.

    Args:
        robot: Dimensions.
        one: The gait, walked straight ahead.
    """
    arrays = cycle_frames(robot, one)
    text = script_json(packed_frames(arrays))
    gait = one.figures.gait
    says = STANDS if gait == STANDING else WALKS.format(gait=gait)
    name = f"The robot, {gait}"
    return PagePicture(name, still_of(arrays, named=True), text, says, kind="replay")


def cycle_frames(robot: RobotParameters, one: WalkedGait) -> dict[str, Any]:
    """Return what is drawn in F frames: each phase of the cycle, and the first once more to close it."""
    cycle = one.cycle
    rows = np.append(np.arange(len(cycle.phase)), 0)
    period_s = 1.0 / (cycle.frequency_hz or 1.0)
    t_s = np.append(cycle.phase - cycle.phase[0], 1.0) * period_s
    valid = cycle.answer.valid[rows]
    loaded: BoolArray = np.where(valid[:, None], cycle.answer.contact[rows], cycle.stance[rows])
    feet = cycle.feet.position_m[rows]
    links = drawn_links(robot, cycle.shafts.angle_rad[rows])
    body = body_of(robot)
    place, turn = _motion(one, rows, t_s, loaded)
    slip = np.linalg.norm(cycle.answer.slip_B[rows], axis=2)
    force_n = np.where(valid[:, None, None], cycle.force_n[rows], np.nan)
    return {
        "names": [f"{number} {name}" for number, name in enumerate(robot.legs.names, start=1)],
        "begin": 0.0,
        "cycle_s": period_s,
        "still": one.figures.gait == STANDING,
        "axes_m": 0.4 * float(np.hypot(*body.size[:2])),
        "t": t_s,
        "place": place,
        "turn": turn,
        "strips": links.strips,
        "points": links.points,
        "feet": feet,
        "loaded": loaded,
        "slip": np.where(loaded & valid[:, None], slip, np.nan),
        "red_from_to": [SHOWN_SLIP_M_S, FULL_SLIP_M_S],
        "measured": np.full_like(force_n, np.nan),
        "predicted": force_n,
        "paths": {},
        "box": [*body.centre.tolist(), *body.size.tolist()],
        "metres_per_newton": METRES_PER_NEWTON,
        "least_n": LEAST_FORCE_N,
    }


def drawn_gaits(
    review: RobotReview, figures: Mapping[str, Figure], replays: Sequence[PagePicture]
) -> list[Section]:
    """Return all pictures of a review; each replay stands before the pictures of its gait.

    Args:
        review: The review.
        figures: ``robot.report.robot_figures.draw_review`` of it.
        replays: Of each gait but the first.
    """
    before = {
        f"{one.figures.gait} feet in stance": Section(f"{one.figures.gait} in 3-D", picture=picture)
        for one, picture in zip(review.gaits[1:], replays, strict=True)
    }
    sections = []
    for section in pictures(figures):
        sections += [before[section.title]] if section.title in before else []
        sections.append(section)
    return sections


def _motion(
    one: WalkedGait, rows: np.ndarray, t_s: FloatArray, loaded: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Place (F, 3) and attitude (F, 4) of the body; level where the model has no answer."""
    answer, feet = one.cycle.answer, one.cycle.feet.position_m[rows]
    velocity = np.nan_to_num(answer.velocity_B[rows])
    steps = exponential(velocity[:-1] * np.diff(t_s)[:, None])
    pose = np.zeros((len(rows), 3))
    for k, step in enumerate(steps):
        pose[k + 1] = compose(pose[k], step)
    slope_x, slope_y, height = answer.pose[rows].T
    lowest = np.where(loaded | ~loaded.any(axis=1, keepdims=True), feet[..., 2], np.inf).min(axis=1)
    up = np.where(np.isfinite(height), height, -lowest)
    angles = np.column_stack([pose[:, 2], np.arctan(slope_x), np.arctan(slope_y)])
    turn = Rotation.from_euler("ZYX", np.nan_to_num(angles)).as_quat()
    return np.column_stack([pose[:, :2], up]), turn
