"""The cameras: body pose and foot markers at the loop's rate, with noise and with what can be wrong.

They see markers, not bodies: the marker frame may sit turned or moved in the body, come late, or live by
a clock of its own. Velocities, forces and contacts they do not see: those are NaN.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from model.values.arrays import FloatArray, IntArray, readonly
from model.values.readings import BodyTruth
from sim_hw.twin.sensing import SensorParameters

# A pose that comes late lies between two of the past; more are not kept than these seconds hold.
KEPT_S = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Body and feet at T times.

    Attributes:
        t_ns: (T,).
        position_W: Body in the world, (T, 3) [m].
        quaternion_xyzw: Body to world, (T, 4).
        foot_position_W: Feet in the world, (T, N, 3) [m].
    """

    t_ns: IntArray
    position_W: FloatArray  # noqa: N815 - frame suffix
    quaternion_xyzw: FloatArray
    foot_position_W: FloatArray  # noqa: N815


class MotionCapture:
    """What the cameras make of the truth.

    Args:
        sensors: Noise and errors.
        seed: Of the noise.
    """

    def __init__(self, sensors: SensorParameters, seed: int) -> None:
        self._sensors = sensors
        self._random = np.random.default_rng([seed, 0x6D])
        self._late = sensors.pose_delay_s > 0 or sensors.pose_clock != 1.0
        self._start_ns = -1
        self._past: list[BodyTruth] = []

    def see(self, truth: BodyTruth) -> BodyTruth:
        """Return the measured pose and feet that go with the time of ``truth``; once a sample."""
        self._past.append(truth)
        keep_ns = truth.t_ns - round(KEPT_S * 1e9)
        while len(self._past) > 2 and (not self._late or self._past[1].t_ns < keep_ns):
            self._past.pop(0)
        past = Poses(
            t_ns=np.array([p.t_ns for p in self._past]),
            position_W=np.array([p.position_W for p in self._past]),
            quaternion_xyzw=np.array([p.quaternion_xyzw for p in self._past]),
            foot_position_W=np.array([p.foot_position_W for p in self._past]),
        )
        seen = self._measure(past, past.t_ns[-1:])
        legs = len(truth.contact)
        nothing = readonly(np.full(3, np.nan))
        return BodyTruth(
            t_ns=truth.t_ns,
            position_W=readonly(seen.position_W[0]),
            quaternion_xyzw=readonly(seen.quaternion_xyzw[0]),
            velocity_B=nothing,
            angular_velocity_B=nothing,
            foot_position_W=readonly(seen.foot_position_W[0]),
            foot_velocity_W=readonly(np.full((legs, 3), np.nan)),
            foot_force_B=readonly(np.full((legs, 3), np.nan)),
            contact=readonly(np.zeros(legs, dtype=bool)),
        )

    def see_all(self, truth: Poses, start_ns: int | None = None) -> Poses:
        """Do at once what one call of ``see`` a sample does.

        Args:
            truth: What is true.
            start_ns: When a clock of the cameras that runs faster was right; None is the first sample.
        """
        self._start_ns = self._start_ns if start_ns is None else start_ns
        return self._measure(truth, truth.t_ns)

    def _measure(self, truth: Poses, t_ns: IntArray) -> Poses:
        """Return what is reported for times, all of them among those of ``truth``."""
        self._start_ns = int(t_ns[0]) if self._start_ns < 0 else self._start_ns
        s, noise = self._sensors, self._sensors.noise
        legs = truth.foot_position_W.shape[1]
        position, to_world, feet = self._when_taken(truth, t_ns)
        draws = self._random.standard_normal((len(t_ns), 6 + 3 * legs))
        origin = position + to_world.apply([*s.pose_origin, 0.0])
        # noise of each angle about its own axis: at this size the order makes no difference
        wobble = Rotation.from_rotvec(noise.body_angle_rad * draws[:, 3:6])
        turned = to_world * Rotation.from_euler("z", s.pose_yaw) * wobble
        feet = feet + noise.foot_position_m * draws[:, 6:].reshape(-1, legs, 3)
        if s.swapped:
            order = np.arange(legs)
            order[list(s.swapped)] = order[list(reversed(s.swapped))]
            feet = feet[:, order]
        return Poses(
            t_ns=t_ns,
            position_W=origin + noise.body_position_m * draws[:, :3],
            quaternion_xyzw=turned.as_quat(canonical=True),
            foot_position_W=feet,
        )

    def _when_taken(self, truth: Poses, t_ns: IntArray) -> tuple[FloatArray, Rotation, FloatArray]:
        """Return where everything was when the frames with these stamps were taken."""
        turns = Rotation.from_quat(truth.quaternion_xyzw)
        if not self._late or len(truth.t_ns) == 1:
            last = slice(len(truth.t_ns) - len(t_ns), None)
            return truth.position_W[last], turns[last], truth.foot_position_W[last]
        since_s = (t_ns - self._start_ns) * 1e-9
        taken_s = since_s / self._sensors.pose_clock - self._sensors.pose_delay_s
        times_s = (truth.t_ns - self._start_ns) * 1e-9
        taken_s = np.clip(taken_s, times_s[0], times_s[-1])
        after = np.clip(np.searchsorted(times_s, taken_s), 1, len(times_s) - 1)
        before = after - 1
        share = (taken_s - times_s[before]) / (times_s[after] - times_s[before])

        def between(values: FloatArray) -> FloatArray:
            weight = share.reshape(-1, *[1] * (values.ndim - 1))
            mixed: FloatArray = (1 - weight) * values[before] + weight * values[after]
            return mixed

        return (
            between(truth.position_W),
            Slerp(times_s, turns)(taken_s),
            between(truth.foot_position_W),
        )
