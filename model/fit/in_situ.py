"""The in-situ calibration as a whole: both stages, judged on poses that neither has seen."""

from dataclasses import dataclass, replace

import numpy as np

from model.errors import ModelError
from model.fit.cross_talk import (
    CrossTalkFit,
    SensorPlaces,
    StillPoses,
    balance_residual,
    fit_cross_talk,
    folds,
    usable,
    wrench_maps,
)
from model.fit.unloaded import UnloadedFit, fit_unloaded
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.force_calibration import AXES, CalibrationOrigin, ForceCalibration, bias_only

HELD_OUT_EVERY = 4
# Less of an unknown than this decided by the data: it is said to be unknown.
LEAST_RESOLUTION = 0.5
# An arc of this length without a sample is worth a warning [rad].
LONG_GAP_RAD = np.pi / 2
SHARED = (
    "all sensors: standing still cannot distinguish errors that all sensors share, seen from the body, "
    "except in vertical force (a common scale of horizontal forces or of moments, say): 30 directions "
    "stay at zero"
)


@dataclass(frozen=True, slots=True, eq=False)
class SensorResidual:
    """RMS of what a sensor's reading fails to explain on poses left out, at the sensor.

    Attributes:
        standing_n: Force of the balance residual [N].
        standing_nm: Its moment about the sensor [N m].
        air_n: Force read with the foot in the air [N]; NaN if it never was.
        air_nm: The same, moment [N m].
    """

    standing_n: float
    standing_nm: float
    air_n: float
    air_nm: float


@dataclass(frozen=True, slots=True, eq=False)
class InSituResult:
    """What the calibration found.

    Attributes:
        calibration: The calibration, from all poses.
        unloaded: Stage one of each sensor, None where the leg was never in the air.
        cross_talk: Stage two; None if it was not asked for.
        before: Residuals on left-out poses with constant offsets only, N of them.
        stage_one: The same with offset and leg gravity.
        after: The same with the whole calibration.
        held_out: Number of standing poses left out for them.
        warnings: What the data do not determine, one sentence each.
    """

    calibration: ForceCalibration
    unloaded: tuple[UnloadedFit | None, ...]
    cross_talk: CrossTalkFit | None
    before: tuple[SensorResidual, ...]
    stage_one: tuple[SensorResidual, ...]
    after: tuple[SensorResidual, ...]
    held_out: int
    warnings: tuple[str, ...]


def calibrate_in_situ(
    poses: StillPoses,
    places: SensorPlaces,
    legs: tuple[str, ...],
    *,
    max_harmonics: int,
    cross_talk: bool = True,
    point_feet: bool = True,
    origin: CalibrationOrigin | None = None,
) -> InSituResult:
    """Calibrate sensors from poses at rest.

    Args:
        poses: Poses at rest, some with feet in the air.
        places: The sensors and the weight.
        legs: Leg names.
        max_harmonics: Most harmonics of the leg's gravity; 0 fits constants.
        cross_talk: Whether to fit the 6 x 6 corrections.
        point_feet: Whether feet touch at a point and take no moment there.
        origin: Where the poses come from, kept with the result; None for no place in particular.

    Raises:
        ModelError: A leg was never in the air, or there are too few poses.
    """
    _check(poses, legs)
    out = folds(poses.angle_rad, HELD_OUT_EVERY) == 0
    kept, left_out = poses.part(~out), poses.part(out)
    _check(kept, legs)
    nothing = np.zeros((len(legs), 6))
    if origin is None:
        origin = CalibrationOrigin(("",) * len(legs))
    blank = replace(bias_only(legs, origin, nothing, nothing), method="in-situ")
    feet = point_feet if cross_talk else None
    constant = _fit(kept, places, blank, 0, None)[0]
    gravity = _fit(kept, places, blank, max_harmonics, None)[0]
    whole = _fit(kept, places, blank, max_harmonics, feet)[0]
    final, unloaded, fit = _fit(poses, places, blank, max_harmonics, feet)
    return InSituResult(
        calibration=final,
        unloaded=unloaded,
        cross_talk=fit,
        before=residuals(constant, left_out, places),
        stage_one=residuals(gravity, left_out, places),
        after=residuals(whole, left_out, places),
        held_out=int(usable(left_out).sum()),
        warnings=_warnings(legs, unloaded, fit, point_feet=point_feet),
    )


def _check(poses: StillPoses, legs: tuple[str, ...]) -> None:
    known = np.isfinite(poses.sensed).all(axis=2)  # (P, N)
    has_sensor = known.any(axis=0)
    lacking = has_sensor & ~(poses.in_air & known).any(axis=0)
    never = [legs[leg] for leg in np.flatnonzero(lacking).tolist()]
    if never:
        raise ModelError(
            f"legs {', '.join(never)} never stood still in the air long enough in two or more "
            "poses; lift each leg to several shaft angles and hold it there for a second"
        )
    if not has_sensor.any():
        raise ModelError("no pose at rest with force readings; record the robot standing still")


def _fit(
    poses: StillPoses,
    places: SensorPlaces,
    blank: ForceCalibration,
    max_harmonics: int,
    point_feet: bool | None,
) -> tuple[ForceCalibration, tuple[UnloadedFit | None, ...], CrossTalkFit | None]:
    """Both stages; without the second where ``point_feet`` is None."""
    count = len(blank.legs)
    fits: list[UnloadedFit | None] = []
    for leg in range(count):
        air = poses.in_air[:, leg] & np.isfinite(poses.sensed[:, leg]).all(axis=1)
        fits.append(
            fit_unloaded(poses.angle_rad[air, leg], poses.sensed[air, leg], max_harmonics)
            if air.any()
            else None
        )
    width = max((fit.coefficients.shape[1] for fit in fits if fit is not None), default=1)
    coefficients = np.full((count, 6, width), np.nan)
    error = np.full((count, 6), np.nan)
    for leg, fit in enumerate(fits):
        if fit is not None:
            coefficients[leg] = 0.0
            coefficients[leg, :, : fit.coefficients.shape[1]] = fit.coefficients
            error[leg] = fit.standard_error(0.0)
    calibration = replace(blank, unloaded=readonly(coefficients), standard_error=readonly(error))
    cross_talk = None
    if point_feet is not None:
        standing = poses.part(usable(poses))
        free = standing.sensed - calibration.unloaded_wrench(standing.angle_rad)
        cross_talk = fit_cross_talk(free, standing, places, point_feet=point_feet)
        calibration = replace(calibration, correction=cross_talk.correction)
    return calibration, tuple(fits), cross_talk


def residuals(
    calibration: ForceCalibration, poses: StillPoses, places: SensorPlaces
) -> tuple[SensorResidual, ...]:
    """Return each sensor's residuals on poses: the balance's, seen from the sensor, and those in air."""
    wrench = calibration.foot_wrench(poses.sensed, poses.angle_rad)
    chosen = usable(poses)
    left = balance_residual(wrench[chosen], poses.part(chosen), places)
    seen = np.einsum("nij,pj->pni", np.linalg.inv(wrench_maps(places)), left)
    out = []
    for leg in range(len(calibration.legs)):
        loaded = ~poses.in_air[chosen, leg]
        air = wrench[poses.in_air[:, leg], leg]
        air = air[np.isfinite(air).all(axis=1)]
        out.append(SensorResidual(*_force_and_moment(seen[loaded, leg]), *_force_and_moment(air)))
    return tuple(out)


def _force_and_moment(wrench: FloatArray) -> tuple[float, float]:
    if len(wrench) == 0:
        return float("nan"), float("nan")
    force, moment = np.sqrt((wrench**2).reshape(-1, 2, 3).sum(axis=2).mean(axis=0)).tolist()
    return force, moment


def _warnings(
    legs: tuple[str, ...],
    unloaded: tuple[UnloadedFit | None, ...],
    fit: CrossTalkFit | None,
    *,
    point_feet: bool,
) -> tuple[str, ...]:
    warnings = []
    for name, stage in zip(legs, unloaded, strict=True):
        if stage is None:
            warnings.append(f"{name}: no sensor readings; not calibrated")
        elif stage.widest_gap_rad > LONG_GAP_RAD:
            warnings.append(
                f"{name}: no sample in the air within {np.degrees(stage.widest_gap_rad) / 2:.0f} deg "
                f"of shaft angle {np.degrees(stage.gap_centre_rad):.0f} deg; leg gravity there is "
                "extrapolated (hang the robot up and turn the leg to see it)"
            )
    if fit is not None:
        for name, known in zip(legs, weak_axes(fit.resolution), strict=True):
            if known.any():
                axes = ", ".join(axis for axis, weak in zip(AXES, known, strict=True) if weak)
                warnings.append(
                    f"{name}: the poses do not tell how a load in {axes} shows in the six readings; "
                    "those corrections stay near zero"
                )
        if not point_feet:
            warnings.append(SHARED)
    return tuple(warnings)


def weak_axes(resolution: FloatArray) -> BoolArray:
    """Return the reading axes whose corrections the data decides by less than half, (N, 6)."""
    weak: BoolArray = resolution.mean(axis=1) < LEAST_RESOLUTION
    return weak
