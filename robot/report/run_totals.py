"""What a summary needs of a log, gathered block by block: one hour fits in sixty megabytes."""

from collections import Counter, defaultdict
from typing import Any

import numpy as np

from model.motion.se2 import yaw_of
from model.values.arrays import FloatArray
from model.values.faults import StopReason
from model.values.tick import Mode
from record.log.recording import Recording
from robot.control.stops import cause_words
from robot.report.ground_truth import true_forward_slip, true_velocity, unwrap_known


class RunTotals:
    """Sums and thin columns over all blocks of a log so far.

    Attributes:
        faults: Ticks in which each kind of fault was, by kind.
        last_faults: When each fault was last [s], and its words, by kind and source.
        stop_s: When the robot began to stop, NaN if it did not.
        stop_cause: The faults that made it stop, in words.
        estimate_sd: The estimator's standard deviations of x, y [m], yaw [rad] at the end, NaN without it.
        gyro_bias: The estimated bias of the yaw gyro and its sd [rad/s] at the end, NaN without a gyro.
    """

    def __init__(self) -> None:
        self.faults: Counter[str] = Counter()
        self.last_faults: dict[tuple[str, str], tuple[float, str]] = {}
        self.stop_s = float("nan")
        self.stop_cause = ""
        self.estimate_sd = np.full(3, np.nan)
        self.gyro_bias = np.full(2, np.nan)
        self._columns: defaultdict[str, list[Any]] = defaultdict(list)

    def add(self, block: Recording) -> None:
        """Add the next block of the log."""
        self._add_faults(block)
        self.estimate_sd = block.estimate_pose_sd[-1]
        self.gyro_bias = block.gyro_bias[-1]
        walking = block.mode == Mode.WALK.value
        predicted, estimate = block.predicted_velocity_B, block.estimate_velocity_B
        true = true_velocity(block)
        for name, values in {
            "t_s": block.t_s,
            "walking": walking,
            "gait_phase": block.gait_phase,
            "dead_reckoning": block.dead_reckoning_pose,
            "estimate": block.estimate_pose,
            "estimate_health": block.estimate_health.astype(np.int8),
            "place": block.truth_position_W[:, :2].copy(),  # a view would keep the heights, too
            "yaw": yaw_of(block.truth_quaternion_xyzw),
            "lateness_s": block.lateness_s,
            "missed": block.missed.sum(keepdims=True),
            "hottest_c": [np.fmax.reduce(block.temperature_c, axis=None)],
            "truth": [block.has_truth],
            "imu": np.isfinite(block.imu).sum(axis=0, keepdims=True),
            "forces": [np.isfinite(block.force_n).any()],
            "true_slip": _known(true_forward_slip(block)[walking]),
            "predicted_slip": _known(block.predicted_slip_B[walking, :, 0]),
            "velocity_rmse": _squares((predicted - true)[walking]),
            "velocity_rms": _squares(true[walking]),
            "force_rmse_n": _squares((block.predicted_force_n - block.force_n)[walking]),
            "estimate_rmse": _squares((estimate - true)[walking]),
            "estimate_force_rmse_n": _squares((block.estimate_force_n - block.force_n)[walking]),
        }.items():
            self._columns[name].append(values)

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

    def column(self, name: str) -> Any:
        """Return what was kept under a name, over all blocks: an array, most with a row a tick."""
        return np.concatenate(self._columns[name])

    def rms(self, name: str) -> tuple[float, ...]:
        """Return the RMS of x, y, z (or vx, vy, yaw rate) that was kept under a name while walking."""
        *total, count = self.column(name).sum(axis=0)
        return tuple(np.sqrt(np.array(total) / (count or np.nan)).tolist())

    @property
    def truth(self) -> bool:
        """Whether any tick had ground truth."""
        return bool(self.column("truth").any())

    def true_pose(self) -> FloatArray:
        """Return true x, y [m] and yaw [rad, unwrapped], (T, 3)."""
        return np.column_stack([self.column("place"), unwrap_known(self.column("yaw"))])


def _squares(rows: FloatArray) -> FloatArray:
    """Sum of squares of each column over the rows, (..., 3), that are known, and their number, (1, 4)."""
    known = rows[np.isfinite(rows).all(axis=-1)]
    return np.array([[*np.sum(known**2, axis=0), len(known)]])


def _known(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]
