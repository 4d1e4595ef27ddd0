"""What a summary needs of a log, gathered block by block: one hour fits in sixty megabytes."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from model.motion.se2 import yaw_of
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.faults import StopReason
from model.values.tick import Mode
from record.log.recording import Recording
from robot.control.stops import cause_words


@dataclass(slots=True)
class SquareMean:
    """Mean square of each column, over the rows in which all are known."""

    total: FloatArray
    count: int = 0

    def add(self, rows: FloatArray) -> None:
        """Add rows, (K, C)."""
        known = rows[np.isfinite(rows).all(axis=1)]
        self.total = self.total + np.sum(known**2, axis=0)
        self.count += len(known)

    def root(self) -> tuple[float, ...]:
        """Return the RMS of each column, NaN for none."""
        if self.count == 0:
            return (float("nan"),) * len(self.total)
        return tuple(float(v) for v in np.sqrt(self.total / self.count))


@dataclass(slots=True)
class RunTotals:
    """Sums and thin columns over all blocks of a log so far.

    Attributes:
        truth: Whether any tick had ground truth.
        missed: Periods missed.
        hottest_c: Highest temperature, NaN while none is known.
        forces: Whether any foot force was measured.
        faults: Ticks in which each kind of fault was, by kind.
        last_faults: When each fault was last [s], and its words, by kind and source.
        stop_s: When the robot began to stop, NaN if it did not.
        stop_cause: The faults that made it stop, in words.
        velocity_error: Predicted minus true body velocity while walking.
        velocity: True body velocity while walking.
        force_error: Predicted minus measured foot force while walking.
        estimate_error: The estimator's minus true body velocity while walking.
        estimate_force_error: Its minus measured foot force while walking.
        estimate_sd: Its standard deviations of x, y [m], yaw [rad] at the end, NaN without it.
    """

    truth: bool = False
    missed: int = 0
    hottest_c: float = float("nan")
    forces: bool = False
    faults: Counter[str] = field(default_factory=Counter)
    last_faults: dict[tuple[str, str], tuple[float, str]] = field(default_factory=dict)
    stop_s: float = float("nan")
    stop_cause: str = ""
    velocity_error: SquareMean = field(default_factory=lambda: SquareMean(np.zeros(3)))
    velocity: SquareMean = field(default_factory=lambda: SquareMean(np.zeros(3)))
    force_error: SquareMean = field(default_factory=lambda: SquareMean(np.zeros(3)))
    estimate_error: SquareMean = field(default_factory=lambda: SquareMean(np.zeros(3)))
    estimate_force_error: SquareMean = field(default_factory=lambda: SquareMean(np.zeros(3)))
    estimate_sd: FloatArray = field(default_factory=lambda: np.full(3, np.nan))
    _columns: dict[str, list[FloatArray | IntArray]] = field(default_factory=dict)
    _true_slip: list[FloatArray] = field(default_factory=list)
    _predicted_slip: list[FloatArray] = field(default_factory=list)

    def add(self, block: Recording) -> None:
        """Add the next block of the log."""
        self.truth = self.truth or block.has_truth
        self.missed += int(block.missed.sum())
        self.hottest_c = float(
            np.fmax.reduce(block.temperature_c, axis=None, initial=self.hottest_c)
        )
        self.forces = self.forces or bool(np.isfinite(block.force_n).any())
        self._add_faults(block)
        walking = block.mode == Mode.WALK.value
        self.velocity_error.add((block.predicted_velocity_B - block.truth_velocity_B)[walking])
        self.velocity.add(block.truth_velocity_B[walking])
        error_n = (block.predicted_force_n - block.force_n)[walking]
        self.force_error.add(error_n.reshape(-1, 3))
        self.estimate_error.add((block.estimate_velocity_B - block.truth_velocity_B)[walking])
        error_n = (block.estimate_force_n - block.force_n)[walking]
        self.estimate_force_error.add(error_n.reshape(-1, 3))
        self.estimate_sd = block.estimate_pose_sd[-1]
        self._true_slip.append(_known(true_forward_slip(block)[walking]))
        self._predicted_slip.append(_known(block.predicted_slip_B[walking, :, 0]))
        for name, values in (
            ("t_s", block.t_s),
            ("mode", block.mode),
            ("gait_phase", block.gait_phase),
            ("dead_reckoning", block.dead_reckoning_pose),
            ("estimate", block.estimate_pose),
            ("estimate_health", block.estimate_health),
            ("place", block.truth_position_W[:, :2]),
            ("yaw", yaw_of(block.truth_quaternion_xyzw)),
            ("lateness_s", block.lateness_s),
        ):
            self._columns.setdefault(name, []).append(values)

    def _add_faults(self, block: Recording) -> None:
        """Note faults, and the cause of a stop in the tick in which it began."""
        seen = sorted({(row, fault.kind.name) for row, fault in block.faults})
        self.faults.update(kind for _, kind in seen)
        for row, fault in block.faults:
            key = (fault.kind.name, fault.source)
            self.last_faults[key] = (float(block.t_s[row]), fault.detail)
        stopping = np.flatnonzero(block.stop_reason != StopReason.NONE.value)
        if len(stopping) and not np.isfinite(self.stop_s):
            first = int(stopping[0])
            self.stop_s = float(block.t_s[first])
            reason = StopReason(int(block.stop_reason[first]))
            self.stop_cause = cause_words(reason, (f for row, f in block.faults if row == first))

    def column(self, name: str) -> FloatArray:
        """Return a thin column over all ticks."""
        return np.concatenate(self._columns[name])

    @property
    def walking(self) -> BoolArray:
        """True in the ticks in which the robot walked, (T,)."""
        flags: BoolArray = self.column("mode") == Mode.WALK.value
        return flags

    def slip_m_s(self) -> FloatArray:
        """Return forward slip of loaded feet while walking, the truth's if there is any truth."""
        return np.concatenate(self._true_slip if self.truth else self._predicted_slip)

    def true_pose(self) -> FloatArray:
        """Return true x, y [m] and yaw [rad, unwrapped], (T, 3)."""
        return np.column_stack([self.column("place"), unwrap_known(self.column("yaw"))])

    def pose(self) -> FloatArray:
        """Return x, y [m] and yaw [rad], (T, 3): the truth's if there is one, else dead reckoning's."""
        return self.true_pose() if self.truth else self.column("dead_reckoning")


def _known(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def unwrap_known(yaw: FloatArray) -> FloatArray:
    """Return a copy of angles without jumps of a turn; NaN stays."""
    yaw = yaw.copy()
    known = np.isfinite(yaw)
    yaw[known] = np.unwrap(yaw[known])
    return yaw


def true_pose(log: Recording) -> FloatArray:
    """Return true x, y [m] and yaw [rad, unwrapped], (T, 3)."""
    yaw = unwrap_known(yaw_of(log.truth_quaternion_xyzw))
    return np.column_stack([log.truth_position_W[:, :2], yaw])


def true_slip(log: Recording) -> FloatArray:
    """Return the true velocity of the feet over the ground in the body's heading, (T, N, 2) [m/s]."""
    yaw = yaw_of(log.truth_quaternion_xyzw)[:, None]
    x, y = log.truth_foot_velocity_W[..., 0], log.truth_foot_velocity_W[..., 1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def true_forward_slip(log: Recording) -> FloatArray:
    """Return the true forward slip of loaded feet, (T, N) [m/s]; NaN in the air."""
    return np.where(log.truth_contact, true_slip(log)[..., 0], np.nan)
