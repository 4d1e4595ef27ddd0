"""The same run twice: the new measurements against the old, leg by leg and for the body.

Both runs are laid one over the other where their feet begin to move: switching torque on takes each robot
its own time. A quantity that either run did not measure is NaN.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.errors import RecordError
from model.motion.se2 import seen_from
from model.values.arrays import FloatArray, root_mean_square
from model.values.tick import Mode
from record.log.recording import Recording
from robot.report.summary import planar_pose

# The least that can be compared.
LEAST_TICKS = 10
COMPARED = (
    "sent_angle_rad", "angle_rad", "current_a", "force_n", "truth_velocity_B",
    "predicted_velocity_B", "dead_reckoning_pose",
)  # fmt: skip
QUIET = (Mode.IDLE.value, Mode.ARMED.value)


@dataclass(frozen=True, slots=True)
class LegRepeat:
    """Root mean square of new minus old for one leg.

    Attributes:
        name: The leg.
        sent_rad: Shaft angle sent.
        angle_rad: Shaft angle measured.
        current_a: Motor current.
        force_n: Measured force on the foot, x, y, z.
    """

    name: str
    sent_rad: float
    angle_rad: float
    current_a: float
    force_n: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """A run and its repetition.

    Attributes:
        duration_s: How much of both lies one over the other.
        old_s: Length of the old run.
        new_s: Length of the new one.
        legs: Differences of each leg.
        true_velocity: RMS difference of the body's true velocity: vx, vy [m/s], yaw rate [rad/s].
        predicted_velocity: The same of the model's.
        old_way: Displacement forward [m], to the left [m] and turn [rad] of the old run, true where known.
        new_way: The same of the new one.
        old_reckoned_way: The same of the old run by dead reckoning.
        new_reckoned_way: The same of the new one.
    """

    duration_s: float
    old_s: float
    new_s: float
    legs: tuple[LegRepeat, ...]
    true_velocity: tuple[float, ...]
    predicted_velocity: tuple[float, ...]
    old_way: tuple[float, ...]
    new_way: tuple[float, ...]
    old_reckoned_way: tuple[float, ...]
    new_reckoned_way: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """Two runs on one time axis, T samples: those of the old run that the new one reaches too.

    Attributes:
        names: Leg names.
        t_s: Time since the feet began to move, (T,).
        old: The old run's arrays, (T, ...), by their names in a ``Recording``; and its ``pose``, true where
            known, else dead reckoning.
        new: The new run's, at the same times.
    """

    names: tuple[str, ...]
    t_s: FloatArray
    old: Mapping[str, FloatArray]
    new: Mapping[str, FloatArray]

    def difference(self, name: str) -> FloatArray:
        """Return new minus old; of angles without whole turns: a servo may count from another one."""
        difference = self.new[name] - self.old[name]
        return turned(difference) if name.endswith("angle_rad") else difference


def overlay(old: Recording, new: Recording) -> Overlay:
    """Lay a run over another.

    Raises:
        RecordError: They have other legs, or one of them is too short.
    """
    if old.names != new.names:
        raise RecordError(
            f"the old run has legs {', '.join(old.names)}, the new one {', '.join(new.names)}"
        )
    old_t, new_t = _moving_time(old), _moving_time(new)
    shared = (old_t >= new_t[0]) & (old_t <= new_t[-1])
    if np.count_nonzero(shared) < LEAST_TICKS:
        raise RecordError("the two runs share less than ten ticks: there is nothing to compare")
    t_s = old_t[shared]
    return Overlay(old.names, t_s, _sampled(old, old_t, t_s), _sampled(new, new_t, t_s))


def _moving_time(log: Recording) -> FloatArray:
    """Time since the first tick of a plan, or since the beginning if there is none."""
    moving = ~np.isin(log.mode, QUIET)
    begin: FloatArray = log.t_s - log.t_s[np.argmax(moving)]
    return begin


def _sampled(log: Recording, own_t_s: FloatArray, t_s: FloatArray) -> Mapping[str, FloatArray]:
    def at(values: FloatArray) -> FloatArray:
        flat = values.reshape(len(values), -1)
        sampled = np.column_stack([np.interp(t_s, own_t_s, column) for column in flat.T])
        return sampled.reshape(len(t_s), *values.shape[1:])

    return {"pose": at(planar_pose(log)), **{name: at(getattr(log, name)) for name in COMPARED}}


def compare_runs(old: Recording, new: Recording, both: Overlay) -> Repeat:
    """Compare two runs that lie one over the other."""
    rms = {name: root_mean_square(both.difference(name)).tolist() for name in COMPARED}
    each_leg = (rms[name] for name in ("sent_angle_rad", "angle_rad", "current_a", "force_n"))
    return Repeat(
        duration_s=float(both.t_s[-1] - both.t_s[0]),
        old_s=float(old.t_s[-1] - old.t_s[0]),
        new_s=float(new.t_s[-1] - new.t_s[0]),
        legs=tuple(
            LegRepeat(name, sent, angle, current, tuple(force))
            for name, sent, angle, current, force in zip(both.names, *each_leg, strict=True)
        ),
        true_velocity=tuple(rms["truth_velocity_B"]),
        predicted_velocity=tuple(rms["predicted_velocity_B"]),
        old_way=_displacement(both.old["pose"]),
        new_way=_displacement(both.new["pose"]),
        old_reckoned_way=_displacement(both.old["dead_reckoning_pose"]),
        new_reckoned_way=_displacement(both.new["dead_reckoning_pose"]),
    )


def turned(difference_rad: FloatArray) -> FloatArray:
    """Return differences of angles without whole turns: a servo may count from another one."""
    return np.asarray(np.angle(np.exp(1j * difference_rad)))


def _displacement(pose: FloatArray) -> tuple[float, ...]:
    known = pose[np.isfinite(pose).all(axis=1)]
    if len(known) < 2:
        return (np.nan,) * 3
    return tuple(seen_from(known[0], known[-1]).tolist())
