"""A trial on the even frames of a machine: what was commanded and measured, and the motion behind it.

Angles, speeds and accelerations are local cubics fitted to the measured angle (Savitzky and Golay), with
the window that predicts a left-out sample best; a logged torque is smoothed alike where both are compared.
"""

from dataclasses import dataclass

import numpy as np

from gap.data.even_grid import even_times, on_times
from gap.machines.mujoco.drive import DriveTable, JointNumbers, pursuing, torque_law
from gap.machines.mujoco.gear_flank import gear_flank
from gap.machines.servo_bench.kernel import UNLIMITED_RAD_S, speed_limited
from model.errors import GapError
from model.motion.filters import at_times, lagged, play
from model.values.arrays import FloatArray
from record.trial.trial import Trial

DEGREE = 3
WINDOWS = (5, 7, 9, 11, 15, 21, 29, 41)
WIDER = 1.5  # for derivatives, than the window that is best for the value
LONG_S = 1e3  # a command holds so long before the first and behind the last sample


@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Smooth motion on the frames: angle, speed, acceleration, (F, J) each; NaN where nothing was measured.

    ``still_rad_s`` is the speed up to which a joint may as well rest, (J,).
    """

    angle: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    still_rad_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """A trial of J joints on F even frames, and its commands as they were logged.

    Attributes:
        trial: The trial itself.
        time_s: From the start, (F,).
        period_s: Between frames.
        shaft_rad: Measured, (F, J); so are the others, NaN where nothing was.
        motion: What lies behind it.
        command_s: When commands were logged, (T,).
        command_rad: Commands, (T, J); the one before where one is missing.
    """

    trial: Trial
    time_s: FloatArray
    period_s: float
    shaft_rad: FloatArray
    shaft_rad_s: FloatArray
    current_a: FloatArray
    torque_nm: FloatArray
    pwm: FloatArray
    motion: JointMotion
    command_s: FloatArray
    command_rad: FloatArray

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.time_s)


def frames_of(trial: Trial, *, commanded: bool) -> Frames:
    """Put a trial on even frames.

    Args:
        trial: The trial.
        commanded: Whether it needs commands.

    Raises:
        GapError: It is too short, nothing was measured at a joint, or a joint has no commands.
    """
    at_s = even_times(trial)
    names = ("shaft_rad", "shaft_rad_s", "current_a", "torque_nm", "pwm")
    put = {name: on_times(trial.time_s, getattr(trial, name), at_s) for name in names}
    command = trial.command_rad.copy()
    for column, angle, joint in zip(command.T, trial.shaft_rad.T, trial.joints, strict=True):
        if not np.isfinite(angle).any():
            raise GapError(
                f"shaft_{joint}_rad is empty: the measured angle of every joint is needed; map its column, "
                f"or leave the joint out of the log"
            )
        if commanded:
            _held(column, joint)
    start = trial.time_s[0]
    return Frames(
        trial=trial,
        time_s=at_s - start,
        period_s=float(at_s[1] - at_s[0]),
        motion=motion_of(trial, at_s),
        command_s=trial.time_s - start,
        command_rad=command,
        **put,
    )


def _held(column: FloatArray, joint: str) -> None:
    """Put the command before where one is missing."""
    known = np.flatnonzero(np.isfinite(column))
    if len(known) == 0:
        raise GapError(
            f"command_{joint}_rad is empty: a position loop is simulated from its commands; map them, or "
            'give [drive] kind = "torque" or "current" beside the log'
        )
    before = np.searchsorted(known, np.arange(len(column)), side="right") - 1
    column[:] = column[known[np.fmax(before, 0)]]


def motion_of(trial: Trial, at_s: FloatArray) -> JointMotion:
    """Fit the motion behind the measured angles of a trial, at other times."""
    period = float(np.median(np.diff(trial.time_s)))
    count = round(float(trial.time_s[-1] - trial.time_s[0]) / period) + 1
    even_s = np.linspace(trial.time_s[0], trial.time_s[-1], count)
    step = float(even_s[1] - even_s[0])
    columns = [
        _fitted(np.interp(even_s, trial.time_s[known], column[known]), step, len(even_s))
        for column in trial.shaft_rad.T
        for known in (np.isfinite(column),)
    ]
    fitted = np.stack([np.stack(one[:3], axis=1) for one in columns], axis=2)
    rows = np.array([[np.interp(at_s, even_s, part) for part in one] for one in fitted.T])
    missing = np.isnan(on_times(trial.time_s, trial.shaft_rad, at_s))
    angle, speed, acceleration = (np.where(missing, np.nan, rows[:, part].T) for part in range(3))
    return JointMotion(angle, speed, acceleration, np.array([one[3] for one in columns]))


def _fitted(
    values: FloatArray, step: float, count: int
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Value, slope and curvature of local cubics, and the slope that noise alone gives."""
    from scipy.signal import (  # a third of a second: as late as it is needed
        savgol_coeffs,
        savgol_filter,
    )

    window, noise = best_window(values)
    wide = min(_odd(WIDER * window), _odd(count - 1) - 2)
    parts = [savgol_filter(values, wide, DEGREE, deriv=d, delta=step) for d in (0, 1, 2)]
    weights = savgol_coeffs(wide, DEGREE, deriv=1, delta=step)
    return parts[0], parts[1], parts[2], 3.0 * noise * float(np.sqrt(weights @ weights))


def best_window(values: FloatArray) -> tuple[int, float]:
    """Return the window whose fits predict left-out samples best, and the noise that they leave."""
    from scipy.signal import savgol_coeffs, savgol_filter

    best, least = WINDOWS[0], np.inf
    for window in WINDOWS:
        if window > len(values) // 2:
            break
        own = float(savgol_coeffs(window, DEGREE)[window // 2])
        rest = (values - savgol_filter(values, window, DEGREE)) / (1.0 - own)
        error = float(np.sqrt(np.mean(rest**2)))
        if error < least:
            best, least = window, error
    own = float(savgol_coeffs(best, DEGREE)[best // 2])
    return best, least * float(np.sqrt(1.0 - own))


def smoothed(values: FloatArray, like: FloatArray) -> FloatArray:
    """Smooth columns (F, J) as the angles ``like`` them are, (F, J); NaN stays NaN."""
    from scipy.signal import savgol_filter

    out = values.copy()
    for column, angle in zip(out.T, like.T, strict=True):
        if np.isfinite(column).all() and np.isfinite(angle).all():
            window = min(_odd(WIDER * best_window(angle)[0]), _odd(len(column) - 1) - 2)
            column[:] = savgol_filter(column, window, DEGREE)
    return out


def _odd(value: float) -> int:
    return 2 * int(value / 2) + 1


def targets_of(
    frames: Frames, drive: DriveTable, joint: int, p: JointNumbers, steps: int
) -> FloatArray:
    """Return what a joint's loop pursues in each step, with so many steps a frame, ((F - 1) steps,).

    A command holds until the next one comes. Each step pursues the mean over its time, which moves
    smoothly with a delay and is the command itself where it held.
    """
    dt = frames.period_s / steps
    at_s: FloatArray = np.arange((frames.count - 1) * steps, dtype=np.float64) * dt - p.delay_s
    command = frames.command_rad[:, joint]
    if drive.after_error and p.kd > 0.0:  # a derivative of steps would be a row of kicks
        target = at_times(frames.command_s, command, at_s)
    else:
        target = _mean_held(frames.command_s, command, at_s, dt)
    if p.speed_limit_rad_s < UNLIMITED_RAD_S:
        # what holds and jumps is as slow as what it samples: a limit above that speed does nothing
        smooth = at_times(frames.command_s, command, at_s)
        target = target - (smooth - speed_limited(smooth, p.speed_limit_rad_s, dt))
    target = lagged(target, p.lag_s, dt)
    if p.play_rad > 0.0:
        target = play(target, p.play_rad, float(frames.motion.angle[0, joint]))
    if drive.after_error and p.kd > 0.0:
        target = target + p.kd / p.kp * np.gradient(target, dt)
    if p.backlash_rad > 0.0:  # the loop holds the motor, and the joint lies at a flank of its gear
        own, seen = drive.joints[joint], frames.motion
        plain = targets_of(frames, drive, joint, pursuing(own, drive), 1)
        law = torque_law(drive.kind, own)
        flank = gear_flank(seen.angle[:, joint], seen.speed[:, joint], plain, law, frames.period_s)
        target = target - 0.5 * p.backlash_rad * at_times(frames.time_s, flank, at_s + p.delay_s)
    return np.asarray((target - p.encoder_offset_rad) / p.encoder_scale)


def _mean_held(
    time_s: FloatArray, values: FloatArray, at_s: FloatArray, span_s: float
) -> FloatArray:
    """Mean over a span, beginning at given times, of a signal that holds from sample to sample."""
    edges = np.concatenate([[time_s[0] - LONG_S], time_s, [time_s[-1] + LONG_S]])
    areas = np.diff(edges) * np.concatenate([values[:1], values])
    total = np.concatenate([[0.0], np.cumsum(areas)])
    ahead, behind = np.interp(at_s + span_s, edges, total), np.interp(at_s, edges, total)
    return np.asarray((ahead - behind) / span_s)
