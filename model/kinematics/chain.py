"""Legs that are chains of hinges and slides: joint angles to feet in the body, and the exact Jacobian.

Everything is known as drawn, in body axes, every joint at its drawn value. A joint then carries all that
hangs on it along a screw, one behind the other from the body to the foot::

    T_j = T_parent(j) exp(screw_j (zero_j + sign_j angle_j)),  foot = T_last foot_drawn - radius z
    d foot / d angle_j = sign_j a_j x (foot - p_j)   for a hinge,  sign_j a_j   for a slide

with a_j, p_j axis and place as ``T_parent(j)`` has them now. This is the product of exponentials (Brockett
1984; Lynch and Park, "Modern Robotics", chapters 4 and 5); it needs no frames on the links. The foot of a
ball is where it touches level ground; what moves there is the ball's matter, which rolls.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.legs import FootMotion
from model.values.parameters import ChainParameters


class ChainArrays(NamedTuple):
    """A chain as the kernels take it; J joints, N legs. As in ``ChainParameters``."""

    parent: IntArray
    slides: BoolArray
    axis: FloatArray
    place: FloatArray
    sign: FloatArray
    zero: FloatArray
    foot_joint: IntArray
    foot: FloatArray
    radius: FloatArray


class ChainKinematics:
    """All legs of a robot whose legs are chains.

    Args:
        chain: As drawn.
    """

    def __init__(self, chain: ChainParameters) -> None:
        self._arrays = _arrays(chain)
        self._joints, self._legs = chain.count, len(chain.foot)

    @property
    def joint_count(self) -> int:
        """Number of joints J of all legs together."""
        return self._joints

    def feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """Return unloaded feet in the body frame.

        Args:
            angle_rad: Joint angles, (..., J) [rad], [m] of slides; NaN makes NaN of the feet behind it.
            rate_rad_s: Joint speeds, (..., J) [rad/s], [m/s].

        Returns:
            Positions and velocities, (..., N, 3); of a ball where it touches, of its matter there.

        Raises:
            ModelError: The shapes are not those of this robot.
        """
        angle, rate = self._rows(angle_rad), self._rows(rate_rad_s)
        if np.shape(angle_rad) != np.shape(rate_rad_s):
            words = (
                f"angles {np.shape(angle_rad)} and speeds {np.shape(rate_rad_s)} differ in shape"
            )
            raise ModelError(f"{words}; give one speed an angle")
        shape = (*np.shape(angle_rad)[:-1], self._legs, 3)
        position, velocity = np.empty(shape), np.empty(shape)
        prepare()
        feet_kernel(
            angle, rate, self._arrays, position.reshape(-1, self._legs, 3),
            velocity.reshape(-1, self._legs, 3),
        )  # fmt: skip
        return FootMotion(position, velocity)

    def jacobian(self, angle_rad: FloatArray) -> FloatArray:
        """Return how feet move with joints, d foot / d angle, (..., N, 3, J) [m/rad], [1] of slides.

        Args:
            angle_rad: Joint angles, (..., J) [rad], [m] of slides.

        Raises:
            ModelError: The shape is not that of this robot.
        """
        angle = self._rows(angle_rad)
        slope = np.zeros((len(angle), self._legs, 3, self._joints))
        prepare()
        jacobian_kernel(angle, self._arrays, slope)
        return slope.reshape(*np.shape(angle_rad)[:-1], self._legs, 3, self._joints)

    def joint_places(self, angle_rad: FloatArray) -> FloatArray:
        """Return a point of each joint's axis in the body frame, (..., J, 3) [m].

        Args:
            angle_rad: Joint angles, (..., J) [rad], [m] of slides.

        Raises:
            ModelError: The shape is not that of this robot.
        """
        angle = self._rows(angle_rad)
        place = np.empty((len(angle), self._joints, 3))
        prepare()
        places_kernel(angle, self._arrays, place)
        return place.reshape(*np.shape(angle_rad), 3)

    def prepare(self) -> None:
        """Load or make the machine code now, so that no tick has to wait for it."""
        prepare()

    def _rows(self, values: FloatArray) -> FloatArray:
        array = np.asarray(values, dtype=np.float64)
        if array.ndim == 0 or array.shape[-1] != self._joints:
            raise ModelError(
                f"joint values {array.shape} are not those of {self._joints} joints; give (..., "
                f"{self._joints})"
            )
        return np.ascontiguousarray(array.reshape(-1, self._joints))


def chain_reach_m(chain: ChainParameters) -> float:
    """Return a distance from its first joint beyond which no foot comes [m]; of slides, as drawn."""
    reaches = []
    for leg, foot in enumerate(chain.foot):
        points = np.array([*chain.place[list(chain.joints_of(leg))], foot])
        reaches.append(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()))
    return max(reaches)


def _arrays(chain: ChainParameters) -> ChainArrays:
    """Own copies, all of the types that the kernels are compiled for."""
    return ChainArrays(
        parent=np.array(chain.parent, dtype=np.int64),
        slides=np.array(chain.slides, dtype=np.bool_),
        axis=np.array(chain.axis, dtype=np.float64, order="C"),
        place=np.array(chain.place, dtype=np.float64, order="C"),
        sign=np.array(chain.sign, dtype=np.float64),
        zero=np.array(chain.zero, dtype=np.float64),
        foot_joint=np.array(chain.foot_joint, dtype=np.int64),
        foot=np.array(chain.foot, dtype=np.float64, order="C"),
        radius=np.array(chain.radius, dtype=np.float64),
    )


@in_place
@compiled
def _carried(turn: FloatArray, point: FloatArray, i: int) -> float:
    """Coordinate ``i`` of a drawn point as a transform, (3, 4), has it now."""
    now: float = turn[i, 3]
    for k in range(3):
        now += turn[i, k] * point[k]
    return now


@compiled
def _pose(angle: FloatArray, chain: ChainArrays, turns: FloatArray, lines: FloatArray) -> None:
    """Where joints put what hangs on them.

    Args:
        angle: (J,).
        chain: The chain.
        turns: Out: rotation and shift of each joint from as drawn, (J, 3, 4).
        lines: Out: axis and place of each joint now, (J, 6).
    """
    own = np.empty((3, 4))
    for j in range(angle.size):
        up, a, p = chain.parent[j], chain.axis[j], chain.place[j]
        by = chain.zero[j] + chain.sign[j] * angle[j]
        if chain.slides[j]:
            for i in range(3):
                for k in range(3):
                    own[i, k] = 1.0 if i == k else 0.0
                own[i, 3] = a[i] * by
        else:
            c, s = np.cos(by), np.sin(by)
            v = 1.0 - c
            own[0, 0], own[0, 1], own[0, 2] = (
                c + a[0] * a[0] * v, a[0] * a[1] * v - a[2] * s, a[0] * a[2] * v + a[1] * s,
            )  # fmt: skip
            own[1, 0], own[1, 1], own[1, 2] = (
                a[1] * a[0] * v + a[2] * s, c + a[1] * a[1] * v, a[1] * a[2] * v - a[0] * s,
            )  # fmt: skip
            own[2, 0], own[2, 1], own[2, 2] = (
                a[2] * a[0] * v - a[1] * s, a[2] * a[1] * v + a[0] * s, c + a[2] * a[2] * v,
            )  # fmt: skip
            for i in range(3):
                own[i, 3] = p[i] - own[i, 0] * p[0] - own[i, 1] * p[1] - own[i, 2] * p[2]
        for i in range(3):
            if up < 0:
                lines[j, i], lines[j, 3 + i] = a[i], p[i]
                for k in range(4):
                    turns[j, i, k] = own[i, k]
            else:
                above = turns[up]
                lines[j, i] = above[i, 0] * a[0] + above[i, 1] * a[1] + above[i, 2] * a[2]
                lines[j, 3 + i] = _carried(above, p, i)
                for k in range(4):
                    turns[j, i, k] = (
                        above[i, 0] * own[0, k] + above[i, 1] * own[1, k] + above[i, 2] * own[2, k]
                    )
                turns[j, i, 3] += above[i, 3]


@in_place
@compiled
def _slope(line: FloatArray, slides: bool, foot: FloatArray) -> tuple[float, float, float]:
    """Motion of a foot with a joint in its drawn sense."""
    if slides:
        return line[0], line[1], line[2]
    x, y, z = foot[0] - line[3], foot[1] - line[4], foot[2] - line[5]
    return line[1] * z - line[2] * y, line[2] * x - line[0] * z, line[0] * y - line[1] * x


@compiled
def feet_kernel(
    angle: FloatArray, rate: FloatArray, chain: ChainArrays, position: FloatArray,
    velocity: FloatArray,
) -> None:  # fmt: skip
    """Feet in the body frame.

    Args:
        angle: Joint angles, (F, J).
        rate: Joint speeds, (F, J).
        chain: The chain.
        position: Out: (F, N, 3) [m].
        velocity: Out: (F, N, 3) [m/s].
    """
    turns, lines = np.empty((angle.shape[1], 3, 4)), np.empty((angle.shape[1], 6))
    for f in range(angle.shape[0]):
        _pose(angle[f], chain, turns, lines)
        for n in range(chain.foot_joint.size):
            j = chain.foot_joint[n]
            for i in range(3):
                position[f, n, i] = _carried(turns[j], chain.foot[n], i)
                velocity[f, n, i] = 0.0
            position[f, n, 2] -= chain.radius[n]
            while j >= 0:
                x, y, z = _slope(lines[j], chain.slides[j], position[f, n])
                speed = chain.sign[j] * rate[f, j]
                velocity[f, n, 0] += x * speed
                velocity[f, n, 1] += y * speed
                velocity[f, n, 2] += z * speed
                j = chain.parent[j]


@compiled
def jacobian_kernel(angle: FloatArray, chain: ChainArrays, slope: FloatArray) -> None:
    """Motion of feet with joints.

    Args:
        angle: Joint angles, (F, J).
        chain: The chain.
        slope: Out: d foot / d angle, (F, N, 3, J); zeros where it comes in stay where a joint is not the
            leg's.
    """
    turns, lines = np.empty((angle.shape[1], 3, 4)), np.empty((angle.shape[1], 6))
    foot = np.empty(3)
    for f in range(angle.shape[0]):
        _pose(angle[f], chain, turns, lines)
        for n in range(chain.foot_joint.size):
            j = chain.foot_joint[n]
            for i in range(3):
                foot[i] = _carried(turns[j], chain.foot[n], i)
            foot[2] -= chain.radius[n]
            while j >= 0:
                x, y, z = _slope(lines[j], chain.slides[j], foot)
                slope[f, n, 0, j] = chain.sign[j] * x
                slope[f, n, 1, j] = chain.sign[j] * y
                slope[f, n, 2, j] = chain.sign[j] * z
                j = chain.parent[j]


@compiled
def places_kernel(angle: FloatArray, chain: ChainArrays, place: FloatArray) -> None:
    """Where the joints are.

    Args:
        angle: Joint angles, (F, J).
        chain: The chain.
        place: Out: (F, J, 3) [m].
    """
    turns, lines = np.empty((angle.shape[1], 3, 4)), np.empty((angle.shape[1], 6))
    for f in range(angle.shape[0]):
        _pose(angle[f], chain, turns, lines)
        for j in range(angle.shape[1]):
            for i in range(3):
                place[f, j, i] = lines[j, 3 + i]


@cache
def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    three, one = np.zeros((1, 3)), np.zeros(1)
    whole, flags = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.bool_)
    chain = ChainArrays(whole, flags, three, three, one, one, whole, three, one)
    compile_for(feet_kernel, *given(2, 2), chain, *out(3, 3))
    compile_for(jacobian_kernel, *given(2), chain, *out(4))
    compile_for(places_kernel, *given(2), chain, *out(3))
