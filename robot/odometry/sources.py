"""How well each kind of measurement fitted what the filter expected, and what the filter rejected."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.estimator.settings import EstimatorSettings
from model.estimator.sources import ABSOLUTE, FORCE, GYRO, LOAD, TILT
from model.values.arrays import FloatArray, IntArray
from robot.odometry.health import periods
from robot.odometry.metrics import chi_squared_quantile
from robot.odometry.track import Track

NAMES = {
    LOAD: "load", FORCE: "friction force", GYRO: "gyro", TILT: "tilt", ABSOLUTE: "absolute pose",
}  # fmt: skip
BLOCK_S = 1.0  # over which innovations are averaged in a picture


@dataclass(frozen=True, slots=True, eq=False)
class SourceFit:
    """The innovations of one kind of measurement, T ticks.

    Attributes:
        name: What was measured.
        squared: Normalised innovation squared of the numbers used in each tick, (T,); 0 without any.
        numbers: How many numbers that were, (T,).
    """

    name: str
    squared: FloatArray
    numbers: IntArray

    @property
    def mean(self) -> float:
        """NIS per degree of freedom, over all ticks; NaN without a measurement."""
        count = int(self.numbers.sum())
        return float(self.squared.sum() / count) if count else np.nan

    def blocks(self, t_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Means over blocks of ``BLOCK_S``, of the B with a measurement.

        Returns:
            Middle [s], NIS per degree of freedom, (B,) each, and the 95 % band of the latter if the
            filter's covariances are right, (2, B).
        """
        block = ((t_s - t_s[0]) / BLOCK_S).astype(np.int64)
        numbers = np.bincount(block, self.numbers)
        squared = np.bincount(block, self.squared)
        used = np.flatnonzero(numbers > 0)
        count = numbers[used]
        band = np.array([chi_squared_quantile(share, count) / count for share in (0.025, 0.975)])
        middle_s = (np.bincount(block, t_s) / np.bincount(block).clip(1))[used]
        return middle_s, squared[used] / count, band

    def in_band(self, t_s: FloatArray) -> float:
        """Share of the blocks in their 95 % band; NaN without a measurement."""
        _, ratio, (low, high) = self.blocks(t_s)
        return float(np.mean((ratio >= low) & (ratio <= high))) if len(ratio) else np.nan


@dataclass(frozen=True, slots=True, eq=False)
class Rejected:
    """Measurements of one kind and leg that the filter rejected.

    Attributes:
        name: What was measured.
        leg: Of which leg, or about which axis; empty for none.
        count: How many.
        periods: Begin and end of each time without a break, (P, 2) [s].
        why: In words.
    """

    name: str
    leg: str
    count: int
    periods: FloatArray
    why: str

    @property
    def place(self) -> str:
        """What and where."""
        return f"{self.name} {self.leg}".strip()


def sources_of(track: Track) -> list[SourceFit]:
    """Return each kind of measurement that was used at least once."""
    squared = np.nan_to_num(track.column("source_nis"))
    numbers = track.column("source_dof").astype(np.int64)
    fits = [SourceFit(NAMES[kind], squared[:, kind], numbers[:, kind]) for kind in NAMES]
    return [one for one in fits if one.numbers.any()]


def rejected_of(track: Track, names: Sequence[str], settings: EstimatorSettings) -> list[Rejected]:
    """Return what was rejected since the first tick, by kind and leg, and why."""
    beyond = "over {:.1f} sd from what was expected"
    kinds = (
        (LOAD, names, beyond.format(settings.gate_load**0.5)),
        (FORCE, names, beyond.format(settings.gate_pair**0.5)),
        (GYRO, ("",), beyond.format(settings.gate_load**0.5)),
        (TILT, ("roll", "pitch"), beyond.format(settings.gate_load**0.5)),
        (ABSOLUTE, ("",), beyond.format(settings.gate_pose**0.5)
         + f", or over {settings.pose_limit:g} m and 5 sd (pose_limit)"),
    )  # fmt: skip
    rows = []
    for kind, legs, why in kinds:
        for leg, of in enumerate(legs):
            among = np.flatnonzero(track.rejections[:, kind, leg])
            if len(among):
                rows.append(
                    Rejected(NAMES[kind], of, len(among), periods(track.t_s, among.tolist()), why)
                )
    return rows
