"""What the sensors do to the truth, apart from the plant: the healthy ones nothing but noise.

``SensorParameters`` say it; ``ForceChannel`` does it to the transducers' wrenches; the encoders' share is
done by ``sim_hw.host.world``, the cameras' by ``sim_hw.twin.motion_capture``.
"""

import math
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from record.trial.header import TrialNoise

# Of a wireless Gamma's forces at 100 Hz, of a dozen cameras' poses, of 4096 ticks a turn; assumed but for
# the ticks.
HEALTHY_NOISE = TrialNoise(
    force_n=0.04,
    body_position_m=0.0002,
    body_angle_rad=0.0005,
    shaft_rad=0.00044,
    foot_position_m=0.0003,
)


@dataclass(frozen=True, slots=True, eq=False)
class SensorParameters:
    """Errors of the sensors; N legs.

    Attributes:
        force_gain: Reading over truth, (N,).
        force_bias: Added to the reading, body axes, (N, 3) [N].
        force_drift: Added to the vertical reading for each second, (N,) [N/s].
        force_yaw: Transducers turned about z beyond what the robot file says, (N,) [rad].
        force_cross_talk: Share of the vertical force that is added to x and y, sensor axes, (N, 2).
        force_delay_s: The stream is so much later than the truth.
        force_lag_s: Time constant of a first-order low-pass; 0 is none.
        pose_delay_s: Poses and markers are so much later than the truth.
        pose_yaw: Marker frame turned in the body [rad].
        pose_origin: Marker frame moved in the body, (2,) [m].
        pose_clock: Rate of the cameras' clock over ours.
        force_filter_s: Time constant of the unit's own first-order filter before that; 0 is none.
        force_wander_n: Standard deviation of a coloured noise on each axis of force [N].
        force_wander_s: Its correlation time.
        marker_share: Share of the give of a leg that its marker goes along with: 1 on the foot, less up the
            shank. The foot that is reported is where it would be at the end of a rigid leg.
        swapped: Two legs whose foot markers are taken for each other, () for none.
        encoder_scale: Reading over truth, (N,).
        noise: One standard deviation of each sensor; NaN for one that is not there.
    """

    force_gain: FloatArray
    force_bias: FloatArray
    force_drift: FloatArray
    force_yaw: FloatArray
    force_cross_talk: FloatArray
    encoder_scale: FloatArray
    pose_origin: FloatArray
    force_delay_s: float = 0.0
    force_lag_s: float = 0.0
    pose_delay_s: float = 0.0
    pose_yaw: float = 0.0
    pose_clock: float = 1.0
    force_filter_s: float = 0.0
    force_wander_n: float = 0.0
    force_wander_s: float = 1.0
    marker_share: float = 1.0
    swapped: tuple[int, ...] = ()
    noise: TrialNoise = HEALTHY_NOISE

    @property
    def forces(self) -> bool:
        """Whether there are transducers."""
        return math.isfinite(self.noise.force_n)

    @property
    def markers(self) -> bool:
        """Whether there are markers on the legs."""
        return math.isfinite(self.noise.foot_position_m)

    @staticmethod
    def healthy(legs: int) -> "SensorParameters":
        """Return sensors with no error but noise."""
        return SensorParameters(
            force_gain=np.ones(legs),
            force_bias=np.zeros((legs, 3)),
            force_drift=np.zeros(legs),
            force_yaw=np.zeros(legs),
            force_cross_talk=np.zeros((legs, 2)),
            encoder_scale=np.ones(legs),
            pose_origin=np.zeros(2),
        )


class ForceChannel:
    """From the wrench on each transducer to what it reports: gain, bias, drift, low-pass, coloured noise.

    Args:
        sensors: Errors.
        seed: Of the coloured noise; the white one is the unit's.
    """

    def __init__(self, sensors: SensorParameters, seed: int = 0) -> None:
        self._sensors = sensors
        self._lags_s = [lag for lag in (sensors.force_filter_s, sensors.force_lag_s) if lag > 0]
        self._last: list[FloatArray] = []
        self._last_ns = 0
        self._start_ns = -1
        self._random = np.random.default_rng([seed, 0x66])
        self._wander = np.zeros((len(sensors.force_gain), 3))
        added = (
            sensors.force_cross_talk.any() or sensors.force_bias.any() or sensors.force_drift.any()
        )
        self._true = bool((sensors.force_gain == 1.0).all() and not added)

    def report(self, wrench: FloatArray, t_ns: int) -> FloatArray:
        """Return the reported wrench, (N, 6), of the true one at a time."""
        s = self._sensors
        self._start_ns = t_ns if self._start_ns < 0 else self._start_ns
        reading = wrench if self._true else self._wrong(wrench, (t_ns - self._start_ns) * 1e-9)
        since_s, self._last_ns = (t_ns - self._last_ns) * 1e-9, t_ns
        stages: list[FloatArray] = []
        for number, lag_s in enumerate(self._lags_s):
            if self._last:
                keep = np.exp(-since_s / lag_s)
                reading = keep * self._last[number] + (1 - keep) * reading
            stages.append(reading)
        self._last = stages
        return self._wandered(reading, since_s) if s.force_wander_n > 0 else reading

    def _wrong(self, wrench: FloatArray, since_s: float) -> FloatArray:
        """Apply gain, cross-talk, bias and drift."""
        s = self._sensors
        reading: FloatArray = wrench * s.force_gain[:, None]
        reading[:, :2] += s.force_cross_talk * reading[:, 2:3]
        reading[:, :3] += s.force_bias
        reading[:, 2] += s.force_drift * since_s
        return reading

    def _wandered(self, reading: FloatArray, since_s: float) -> FloatArray:
        """Add a first-order random process to each force."""
        s = self._sensors
        keep = np.exp(-since_s / s.force_wander_s)
        kick = s.force_wander_n * np.sqrt(1 - keep**2)
        self._wander = keep * self._wander + kick * self._random.standard_normal(self._wander.shape)
        noisy: FloatArray = reading.copy()
        noisy[:, :3] += self._wander
        return noisy
