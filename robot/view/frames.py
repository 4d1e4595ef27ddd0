"""Where the robot is drawn: ``map`` > ``odom`` > ``base_link`` (REP-105), and the ground truth. Pure."""

from dataclasses import dataclass

import numpy as np

from model.motion.se2 import aligning, quaternion_of, yaw_of
from model.values.arrays import FloatArray
from model.values.readings import BodyTruth
from model.values.tick import DeadReckoning, Tick
from robot.report.scene import ESTIMATED, MEASURED, PREDICTED, Colour

MAP_FRAME, ODOM_FRAME, BODY_FRAME, TRUE_FRAME = "map", "odom", "base_link", "base_link_true"
# A trajectory gets a new point after this way, and keeps at most so many.
POINT_EVERY_M = 0.002
MOST_POINTS = 5000


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """A child frame in its parent: translation (3,) [m], rotation (4,) x y z w."""

    parent: str
    child: str
    translation: FloatArray
    rotation_xyzw: FloatArray


class FrameTracker:
    """Turns ticks into transforms and trajectories.

    Dead reckoning begins at its own zero, so ``odom`` is put into ``map`` where the truth is when it is
    first known; from there on the two drift apart, and that is what is to be seen.
    """

    def __init__(self) -> None:
        self._odom_in_map: Transform | None = None
        self._height_m = 0.0
        self.reckoned: list[FloatArray] = []
        self.true: list[FloatArray] = []
        self.estimated: list[FloatArray] = []

    def trajectories(self) -> tuple[tuple[str, str, list[FloatArray], Colour], ...]:
        """Return name, frame, points and colour of each trajectory."""
        return (
            ("true", MAP_FRAME, self.true, MEASURED),
            ("dead reckoning", ODOM_FRAME, self.reckoned, PREDICTED),
            ("estimator", ODOM_FRAME, self.estimated, ESTIMATED),
        )

    def transforms(self, tick: Tick) -> tuple[Transform, ...]:
        """Return the transforms of a tick, and take its places into the trajectories."""
        reckoned = tick.dead_reckoning
        height_m = tick.contact.support.height_m
        if np.isfinite(height_m):
            self._height_m = height_m
        body = Transform(
            ODOM_FRAME,
            BODY_FRAME,
            np.array([*reckoned.position_m, self._height_m]),
            quaternion_of(reckoned.yaw_rad),
        )
        truth = tick.inputs.truth
        known = truth is not None and bool(np.isfinite(truth.position_W).all())
        if truth is None or not known or not np.isfinite(truth.quaternion_xyzw).all():
            nowhere = Transform(MAP_FRAME, ODOM_FRAME, np.zeros(3), quaternion_of(0.0))
            transforms: tuple[Transform, ...] = (self._odom_in_map or nowhere, body)
            if truth is not None and known:  # a place without an attitude
                _extend(self.true, truth.position_W)
        else:
            if self._odom_in_map is None:
                self._odom_in_map = _odom_in_map(truth, reckoned)
            actual = Transform(MAP_FRAME, TRUE_FRAME, truth.position_W, truth.quaternion_xyzw)
            transforms = (self._odom_in_map, body, actual)
            _extend(self.true, truth.position_W)
        if np.isfinite(body.translation).all():
            _extend(self.reckoned, body.translation)
        estimate = tick.estimate
        if estimate is not None and np.isfinite(estimate.position_m).all():
            _extend(self.estimated, np.array([*estimate.position_m, self._height_m]))
        return transforms


def _odom_in_map(truth: BodyTruth, reckoned: DeadReckoning) -> Transform:
    """Put ``odom`` where dead reckoning agrees with the truth."""
    there = np.array([*truth.position_W[:2], yaw_of(truth.quaternion_xyzw)])
    x, y, yaw = aligning(there, reckoned.pose)
    return Transform(MAP_FRAME, ODOM_FRAME, np.array([x, y, 0.0]), quaternion_of(yaw))


def _extend(points: list[FloatArray], place: FloatArray) -> None:
    """Add a place that is far enough from the last one; thin out when there are too many."""
    if points and np.linalg.norm(place - points[-1]) < POINT_EVERY_M:
        return
    points.append(np.array(place))
    if len(points) > MOST_POINTS:
        del points[1::2]
