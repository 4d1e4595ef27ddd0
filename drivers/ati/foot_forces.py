"""From counts to the ground's force on each foot: pure."""

from collections.abc import Sequence
from math import isfinite

import numpy as np

from drivers.ati.calibration import Calibration
from drivers.ati.settings import ForceSensorSettings
from model.compiled import COUNT, FLAG, compile_for, compiled, given, in_place, out
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.input_rows import RecordRows
from model.values.legs import FootForces
from model.values.readings import ForceRecord
from model.values.tick_rows import ForceRows

UNKNOWN = (np.nan,) * 6


def sensed_wrenches(
    record: ForceRecord, calibrations: Sequence[Calibration | None], settings: ForceSensorSettings
) -> FloatArray:
    """Return what the transducers read, sensor axes, (N, 6) [N, N m], nothing subtracted.

    Args:
        record: The record.
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number of each leg.

    Returns:
        NaN where a leg has no transducer, no calibration, is not in the record, or is saturated.
    """
    rows = record.counts, record.present, record.saturated
    return np.array(_rows(*rows, calibrations, settings))


def _rows(
    counts_of: IntArray, present_of: BoolArray, saturated_of: BoolArray,
    calibrations: Sequence[Calibration | None], settings: ForceSensorSettings,
) -> list[tuple[float, ...]]:  # fmt: skip
    """The same as plain numbers, a row a leg: six rows are done sooner one by one."""
    counts: list[list[int]] = counts_of.tolist()
    present, saturated = present_of.tolist(), saturated_of.tolist()
    sensed: list[tuple[float, ...]] = [UNKNOWN] * len(settings.names)
    numbered = zip(settings.transducers.tolist(), calibrations, strict=False)
    for leg, (number, calibration) in enumerate(numbered):
        if calibration is None or number < 1:
            continue
        if not present[number - 1] or saturated[number - 1]:
            continue
        n, nm = calibration.counts_per_n, calibration.counts_per_nm
        fx, fy, fz, tx, ty, tz = counts[number - 1]
        sensed[leg] = (fx / n, fy / n, fz / n, tx / nm, ty / nm, tz / nm)
    return sensed


def foot_wrenches(
    sensed: FloatArray, settings: ForceSensorSettings, angle_rad: FloatArray
) -> FloatArray:
    """Return the ground's wrench on each foot at the sensors, sensor axes, (..., N, 6) [N, N m].

    The calibration file, where there is one, takes the place of the robot file's constant bias.

    Args:
        sensed: Readings, (..., N, 6).
        settings: Calibration or bias of each leg.
        angle_rad: Shaft angles, (..., N); a calibrated leg whose weight shows needs its own.
    """
    if settings.calibration is not None:
        return settings.calibration.foot_wrench(sensed, angle_rad)
    wrench = sensed.copy()
    wrench[..., :3] -= settings.bias_n
    return wrench


def no_forces(count: int) -> FootForces:
    """What is known of the forces on so many feet before the first record."""
    nothing = np.full((count, 3), np.nan)
    return FootForces(-1, readonly(nothing), readonly(np.zeros(count, dtype=bool)))


@in_place
@compiled
def calibrated_forces(
    counts: IntArray,
    present: BoolArray,
    saturated: BoolArray,
    slots: IntArray,
    counts_per_n: FloatArray,
    mounting: FloatArray,
    force_n: FloatArray,
    valid: BoolArray,
) -> None:
    """Write the ground's forces on the feet, body axes, with a constant bias.

    Args:
        counts: Of all transducers, (6, 6).
        present: Which of them are in the record, (6,).
        saturated: Which of them are saturated, (6,).
        slots: Of each leg, -1 for none, (N,).
        counts_per_n: Of each leg's transducer, (N,).
        mounting: Cosine and sine of its turn about z, +1 where it is upright, else -1; its bias on x, y and
            z [N]; a row a leg, (N, 6).
        force_n: (N, 3) [N], NaN where nothing is known; written.
        valid: Whether it is known, (N,); written.
    """
    for leg in range(len(slots)):
        slot = slots[leg]
        valid[leg] = False
        if slot >= 0 and present[slot] and not saturated[slot]:
            n = counts_per_n[leg]
            c, s, up = mounting[leg, 0], mounting[leg, 1], mounting[leg, 2]
            x = counts[slot, 0] / n - mounting[leg, 3]
            y = up * (counts[slot, 1] / n - mounting[leg, 4])
            force_n[leg, 0] = c * x - s * y
            force_n[leg, 1] = s * x + c * y
            force_n[leg, 2] = up * (counts[slot, 2] / n - mounting[leg, 5])
            valid[leg] = np.isfinite(force_n[leg, 0] + force_n[leg, 1] + force_n[leg, 2])
        if not valid[leg]:
            force_n[leg] = np.nan


@in_place
@compiled
def forces_in_rows(
    counts: IntArray, present: BoolArray, saturated: BoolArray, slots: IntArray,
    counts_per_n: FloatArray, mounting: FloatArray, force_n: FloatArray, valid: BoolArray,
) -> None:  # fmt: skip
    """``calibrated_forces`` of T records: all but what belongs to the legs has a row of each."""
    for k in range(len(counts)):
        calibrated_forces(
            counts[k], present[k], saturated[k], slots, counts_per_n, mounting, force_n[k], valid[k]
        )


def prepare() -> None:
    """Load or make the machine code, so that no tick waits for it."""
    compile_for(
        calibrated_forces, *given(2, kind=COUNT), *given(1, 1, kind=FLAG), *given(1, kind=COUNT),
        *given(1, 2), *out(2), *out(1, kind=FLAG),
    )  # fmt: skip


class ForceScales:
    """Calibrates records, one a tick, with what never changes worked out beforehand.

    Args:
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number, rotation, bias and in-situ calibration of each leg.
    """

    def __init__(
        self, calibrations: Sequence[Calibration | None], settings: ForceSensorSettings
    ) -> None:
        self._calibrations = calibrations
        self._settings = settings
        yaw = settings.yaw_rad
        in_situ = settings.calibration is not None
        bias_n = np.zeros_like(settings.bias_n) if in_situ else settings.bias_n
        upright = settings.up.astype(np.float64)
        self._mounting = np.column_stack([np.cos(yaw), np.sin(yaw), upright, bias_n])
        known = [
            number - 1 if one is not None and number > 0 else -1
            for number, one in zip(settings.transducers.tolist(), calibrations, strict=False)
        ]
        missing = [-1] * (len(settings.names) - len(known))
        self._slots = np.array(known + missing, dtype=np.int64)
        scales = [1.0 if one is None else one.counts_per_n for one in calibrations]
        self._counts_per_n = np.array(scales + [1.0] * len(missing))

    def forces(self, record: ForceRecord, angle_rad: FloatArray) -> FootForces:
        """Calibrate one record.

        Args:
            record: The record.
            angle_rad: Shaft angles, (N,), NaN where unknown.

        Returns:
            Forces in body axes. NaN and ``valid`` False where a leg has no transducer, no calibration, is
            not in the record, is saturated, or is not in the calibration file that is in use.
        """
        count = len(self._slots)
        force_n, valid = np.empty((count, 3)), np.empty(count, dtype=np.bool_)
        if self._settings.calibration is None:
            # copies, as those of a log may lie anywhere in it
            counts, present = record.counts.copy(), record.present.copy()
            calibrated_forces(
                counts, present, record.saturated.copy(), self._slots, self._counts_per_n,
                self._mounting, force_n, valid,
            )  # fmt: skip
        else:
            rows = record.counts, record.present, record.saturated
            force_n, valid = self._in_situ(*rows, angle_rad)
        return FootForces(record.t_ns, readonly(force_n), readonly(valid))

    def _in_situ(
        self, counts: IntArray, present: BoolArray, saturated: BoolArray, angle_rad: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """Forces, (N, 3), and whether they are known, by the calibration file."""
        sensed = _rows(counts, present, saturated, self._calibrations, self._settings)
        wrenches = foot_wrenches(np.array(sensed), self._settings, angle_rad).tolist()
        force_n, valid = np.empty((len(sensed), 3)), np.empty(len(sensed), dtype=np.bool_)
        for leg, ((fx, fy, fz, *_), (c, s, up, *_)) in enumerate(
            zip(wrenches, self._mounting.tolist(), strict=True)
        ):
            y = up * fy
            force = (c * fx - s * y, s * fx + c * y, up * fz)
            valid[leg] = isfinite(force[0] + force[1] + force[2])
            force_n[leg] = force if valid[leg] else np.nan
        return force_n, valid

    def rows(self, records: RecordRows, angle_rad: FloatArray, before: FootForces) -> ForceRows:
        """Newest forces in T ticks: where one brings no record, those of the tick before.

        Args:
            records: The newest of each tick; calibrated as by ``forces``.
            angle_rad: Shaft angles, (T, N).
            before: Forces in the tick before the first.
        """
        count, legs = len(records.there), len(self._slots)
        t_ns, force_n = np.empty(count + 1, dtype=np.int64), np.empty((count + 1, legs, 3))
        valid = np.empty((count + 1, legs), dtype=np.bool_)
        t_ns[0], force_n[0], valid[0] = before.t_ns, before.force_n, before.valid
        t_ns[1:] = records.t_ns
        if self._settings.calibration is None:
            compile_for(
                forces_in_rows, *given(3, kind=COUNT), *given(2, 2, kind=FLAG), *given(1, kind=COUNT),
                *given(1, 2), *out(3), *out(2, kind=FLAG),
            )  # fmt: skip
            forces_in_rows(
                records.counts, records.present, records.saturated, self._slots, self._counts_per_n,
                self._mounting, force_n[1:], valid[1:],
            )  # fmt: skip
        else:
            for k in np.flatnonzero(records.there).tolist():
                rows = records.counts[k], records.present[k], records.saturated[k]
                force_n[k + 1], valid[k + 1] = self._in_situ(*rows, angle_rad[k])
        at = np.where(records.there, np.arange(1, count + 1), 0)
        newest = np.maximum.accumulate(at)
        return ForceRows(readonly(t_ns[newest]), readonly(force_n[newest]), readonly(valid[newest]))
