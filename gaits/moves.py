"""Moving one leg at a time: to the stand, and to the pose a gait begins with.

Only one shaft turns at any moment, so at most one foot is dragged and the others carry the robot.
"""

import math
from dataclasses import dataclass

import numpy as np

from gaits.gait import TURN, Gait
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.parameters import ServoParameters

# Peak speed of a move, and the share of the servo's limit that it keeps to if that is slower.
MOVE_SPEED_RAD_S = 2.0
MOVE_SHARE = 0.5
SHORTEST_MOVE_S = 0.3
QUINTIC_PEAK = 1.875  # peak speed of the quintic over its mean speed
QUINTIC_BEND = 10 / math.sqrt(3)  # its peak acceleration for a change of 1 rad in 1 s
# A shaft further than this from mid-stance holds its foot in the air.
AIR_RAD = np.pi / 2
SMALLEST_MOVE_RAD = 1e-9


@dataclass(frozen=True, slots=True)
class MovePace:
    """How fast legs move to their places.

    Attributes:
        speed_rad_s: Peak speed of a shaft.
        acceleration_rad_s2: Its peak acceleration.
    """

    speed_rad_s: float
    acceleration_rad_s2: float

    @staticmethod
    def of(servo: ServoParameters) -> "MovePace":
        """Return the pace of a robot's servos, well within what gaits may ask of them."""
        speed = min(MOVE_SPEED_RAD_S, MOVE_SHARE * servo.max_speed)
        return MovePace(speed, servo.max_acceleration)

    def duration_s(self, change_rad: float) -> float:
        """Return how long a move by so much takes."""
        by_speed = QUINTIC_PEAK * change_rad / self.speed_rad_s
        by_acceleration = math.sqrt(QUINTIC_BEND * change_rad / self.acceleration_rad_s2)
        return max(SHORTEST_MOVE_S, by_speed, by_acceleration)


def quintic(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the share of a move that is at rest at both ends, and its slope, at shares x of its time."""
    return x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2


@dataclass(frozen=True, slots=True, eq=False)
class LegMoves:
    """A sequence of moves, one leg after the other, each at rest at both ends.

    Attributes:
        begin_rad: Shaft angles before, (N,).
        end_rad: Shaft angles after, (N,).
        start_ns: When each leg begins to move, (N,) int64.
        stop_ns: When it has arrived, (N,) int64.
    """

    begin_rad: FloatArray
    end_rad: FloatArray
    start_ns: IntArray
    stop_ns: IntArray

    @property
    def end_ns(self) -> int:
        """When the last leg has arrived."""
        return int(self.stop_ns.max())

    def at(self, t_ns: int) -> tuple[FloatArray, FloatArray]:
        """Return shaft angles [rad] and speeds [rad/s], (N,) each."""
        span_s = np.maximum(self.stop_ns - self.start_ns, 1) * 1e-9
        x = np.minimum(np.maximum((t_ns - self.start_ns) * 1e-9 / span_s, 0.0), 1.0)
        change, (share, slope) = self.end_rad - self.begin_rad, quintic(x)
        return self.begin_rad + change * share, change * slope / span_s

    @staticmethod
    def sequence(
        t_ns: int, begin_rad: FloatArray, end_rad: FloatArray, order: IntArray, pace: MovePace
    ) -> "LegMoves":
        """Move legs one after the other.

        Args:
            t_ns: When the first begins.
            begin_rad: Angles now, (N,).
            end_rad: Angles wanted, (N,).
            order: Legs in the order in which they move, (N,).
            pace: How fast.
        """
        starts = np.full(len(begin_rad), t_ns, dtype=np.int64)
        stops = starts.copy()
        now = t_ns
        for leg in order:
            change = abs(float(end_rad[leg] - begin_rad[leg]))
            starts[leg] = now
            if change > SMALLEST_MOVE_RAD:
                now += round(pace.duration_s(change) * 1e9)
            stops[leg] = now
        return LegMoves(
            readonly(begin_rad.copy()), readonly(end_rad.copy()), readonly(starts), readonly(stops)
        )

    @staticmethod
    def stand(t_ns: int, angle_rad: FloatArray, pace: MovePace) -> "LegMoves":
        """Come to stand on all feet: every shaft to mid-stance.

        Feet in the air come down first, going on forward as in a step; then the feet on the ground
        are set straight the short way.
        """
        offset = _wrap(angle_rad)
        in_air = np.abs(offset) > AIR_RAD
        short = angle_rad - offset
        forward = np.where(offset > 0, short + TURN, short)
        target = np.where(in_air, forward, short)
        order = np.lexsort((-np.abs(offset), ~in_air))
        return LegMoves.sequence(t_ns, angle_rad, target, order, pace)

    @staticmethod
    def start(t_ns: int, gait: Gait, angle_rad: FloatArray, pace: MovePace) -> "LegMoves":
        """Move to the pose a gait begins with, the short way round.

        Legs that begin on the ground go first, so that they carry when the others lift.
        """
        pose = gait.motion(gait.start_phase, 0.0).angle_rad
        target = angle_rad + _wrap(pose - angle_rad)
        in_air = np.abs(_wrap(pose)) > AIR_RAD
        order = np.lexsort((np.arange(len(pose)), in_air))
        return LegMoves.sequence(t_ns, angle_rad, target, order, pace)


def _wrap(angle_rad: FloatArray) -> FloatArray:
    wrapped: FloatArray = np.remainder(angle_rad + np.pi, TURN) - np.pi
    return wrapped
