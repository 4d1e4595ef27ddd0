"""Faults of a log that no physics should be blamed for: units, a gearbox's wrong side, another robot."""

from collections.abc import Iterator

import numpy as np

from gap.data.columns import paired
from gap.interfaces import DataFault
from gap.machines.mujoco.rigid_model import RigidModel
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

SAMPLED_S = (1e-5, 0.5)
TURN_RAD = 2 * np.pi
BEYOND_RANGE = 5.0  # times a joint's range, that no angle of it reaches
MOVES_RAD_S = 0.02
FEWEST = 30
AGREE = (0.8, 1.25)
ALIKE = 0.9
FASTEST_RAD_S = 60.0  # of a joint, for a tenth of the time
TORQUES_APART = 100.0  # times what the loop gives, that a model needs along the same motion
UNITS = ((180 / np.pi, "deg"), (1000.0, "mrad"), (4096 / TURN_RAD, "ticks of 4096"))


def refuse_other_units(trial: Trial, rigid: RigidModel) -> None:
    """Make sure that time and angles can be those of the model.

    Raises:
        GapError: They cannot.
    """
    period = float(np.median(np.diff(trial.time_s))) if len(trial.time_s) > 1 else 0.01
    if not SAMPLED_S[0] <= period <= SAMPLED_S[1]:
        raise GapError(
            f"samples lie {period:.4g} s apart, which no log of a moving robot does: map its time with its "
            'unit, as in time_s = {from = "time", unit = "ms"}'
        )
    model = rigid.model
    for at, joint in enumerate(rigid.joints):
        number = model.dof_jntid[rigid.speed[at]]
        limited = bool(model.jnt_limited[number])
        reach = float(np.max(np.abs(model.jnt_range[number]))) if limited else 10 * TURN_RAD
        angle = trial.shaft_rad[np.isfinite(trial.shaft_rad[:, at]), at]
        most = float(np.max(np.abs(angle), initial=0.0))
        if most > BEYOND_RANGE * max(reach, 1.0):
            unit = next(
                (f', unit = "{name}"?' for size, name in UNITS if most / size <= 1.2 * reach), ""
            )
            raise GapError(
                f"shaft_{joint}_rad reaches {most:.4g} rad, {rigid.in_file[at]} of the model {reach:.3g}: "
                f"another unit or another robot's joint; correct the map{unit}"
            )
        turning = np.abs(np.diff(angle)) / period
        fast = float(np.percentile(turning, 90)) if len(turning) else 0.0
        if fast > FASTEST_RAD_S:
            raise GapError(
                f"shaft_{joint}_rad turns at {fast:.3g} rad/s for a tenth of the time, which no joint of a "
                'robot does: map its angle, and its command, with their unit: unit = "deg"?'
            )


def refuse_other_torques(needed: FloatArray, given: FloatArray) -> None:
    """Make sure that the torque that a model needs along a motion can be that of its drive, (F, J) each.

    Raises:
        GapError: It cannot: masses, lengths or gains are in other units.
    """
    whole = np.isfinite(needed) & np.isfinite(given)
    need, give = (float(np.sqrt(np.mean(one[whole] ** 2))) for one in (needed, given))
    if whole.any() and need > TORQUES_APART * give > 0.0:
        raise GapError(
            f"along the measured motion the model needs {need:.3g} N m (RMS), the loop as described gives "
            f"{give:.3g}: masses in g, gains in other units, or a feed-forward that is not in [drive]? "
            "correct the model or [drive]"
        )


def speeds_disagree(trial: Trial) -> bool:
    """Whether a logged speed is so many times the derivative of its angle that it is another quantity."""
    return any(not AGREE[0] < ratio < AGREE[1] for _, ratio in _speed_ratios(trial))


def _speed_ratios(trial: Trial) -> Iterator[tuple[str, float]]:
    """Logged speed over the derivative of the angle, of every joint where one follows the other."""
    if len(trial.time_s) < FEWEST:
        return
    for at, joint in enumerate(trial.joints):
        logged, angle = trial.shaft_rad_s[:, at], trial.shaft_rad[:, at]
        if not np.isfinite(logged).any():
            continue
        there, motion = paired(logged, np.gradient(angle, trial.time_s))
        moving = np.abs(motion) > MOVES_RAD_S
        if moving.sum() < FEWEST or there[moving].std() == 0.0:
            continue
        there, motion = there[moving], motion[moving]
        if abs(float(np.corrcoef(there, motion)[0, 1])) > ALIKE:
            yield joint, float(there @ motion / (motion @ motion))


def check_log(trial: Trial) -> Iterator[DataFault]:
    """Look through a log of joints."""
    for joint, ratio in _speed_ratios(trial):
        if not AGREE[0] < ratio < AGREE[1]:
            words = (
                f"is {ratio:.4g} times the derivative of the angle: another unit, or the motor's side of "
                "the gearbox; speeds are taken from the angle"
            )
            yield DataFault("sign" if ratio < 0 else "unit", f"shaft_{joint}_rad_s", words, False)


def torque_ratio(measured: FloatArray, needed: FloatArray) -> float:
    """Return how many times what a motion needs a measured torque is, by their sizes; NaN if unknown."""
    there, wanted = paired(measured, needed)
    if len(there) < FEWEST or not np.any(wanted):
        return np.nan
    return float(np.median(np.abs(there)) / max(float(np.median(np.abs(wanted))), 1e-12))
