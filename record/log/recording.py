"""A log as arrays: T ticks of N legs, for tables, plots and comparisons."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.estimate import Estimate
from model.values.faults import Fault
from model.values.readings import BodyTruth
from model.values.tick import Tick
from record.log.estimate_message import HEALTHS

NOT_RUNNING = -1


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A log, T ticks.

    Attributes:
        names: Leg names, N of them.
        t_s: Time since the beginning, (T,).
        mode: Mode codes, (T,).
        stop_reason: Stop reason codes, (T,).
        gait_phase: (T,) [cycles]; NaN when no gait runs.
        angle_rad: Measured shaft angles, (T, N).
        rate_rad_s: Measured shaft speeds, (T, N).
        current_a: Motor currents, (T, N).
        temperature_c: Servo temperatures, (T, N).
        sent_angle_rad: Angles sent, (T, N); NaN while torque is off.
        force_n: Measured ground forces on the feet, body axes, (T, N, 3); NaN where invalid.
        predicted_force_n: The model's, (T, N, 3).
        predicted_velocity_B: The model's body velocity: vx, vy [m/s], yaw rate [rad/s], (T, 3).
        predicted_slip_B: The model's slip of each foot, (T, N, 2); NaN in the air.
        dead_reckoning_pose: Open loop: x, y [m], yaw [rad], (T, 3).
        estimate_pose: The estimator's: x, y [m], yaw [rad], (T, 3); NaN where it did not run.
        estimate_pose_sd: Their standard deviations, (T, 3).
        estimate_velocity_B: vx, vy [m/s], yaw rate [rad/s], (T, 3).
        estimate_force_n: Its forces, (T, N, 3).
        estimate_health: 0 ok, 1 degraded, 2 lost, -1 not running, (T,).
        truth_position_W: (T, 3); NaN where there is no truth. So in all fields of the truth.
        truth_quaternion_xyzw: (T, 4).
        truth_velocity_B: vx, vy [m/s], yaw rate [rad/s], (T, 3).
        truth_foot_velocity_W: (T, N, 3).
        truth_force_n: (T, N, 3), body axes.
        truth_contact: (T, N) bool.
        lateness_s: Lateness of each tick, (T,).
        busy_s: Time the tick before spent working, (T,).
        missed: Periods missed before each tick, (T,).
        faults: Row of the tick in these arrays, and fault; in order.
        config_text: The robot file.
        metadata: Metadata texts.
        damage: Empty, or how the file ends early.
    """

    names: tuple[str, ...]
    t_s: FloatArray
    mode: IntArray
    stop_reason: IntArray
    gait_phase: FloatArray
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    current_a: FloatArray
    temperature_c: FloatArray
    sent_angle_rad: FloatArray
    force_n: FloatArray
    predicted_force_n: FloatArray
    predicted_velocity_B: FloatArray  # noqa: N815
    predicted_slip_B: FloatArray  # noqa: N815
    dead_reckoning_pose: FloatArray
    estimate_pose: FloatArray
    estimate_pose_sd: FloatArray
    estimate_velocity_B: FloatArray  # noqa: N815
    estimate_force_n: FloatArray
    estimate_health: IntArray
    truth_position_W: FloatArray  # noqa: N815
    truth_quaternion_xyzw: FloatArray
    truth_velocity_B: FloatArray  # noqa: N815
    truth_foot_velocity_W: FloatArray  # noqa: N815
    truth_force_n: FloatArray
    truth_contact: BoolArray
    lateness_s: FloatArray
    busy_s: FloatArray
    missed: IntArray
    faults: tuple[tuple[int, Fault], ...]
    config_text: str
    metadata: Mapping[str, str]
    damage: str

    @property
    def has_truth(self) -> bool:
        """Whether there is ground truth anywhere."""
        return bool(np.isfinite(self.truth_position_W).any())


def _estimated(take: Callable[[Estimate], object]) -> Callable[[Tick], object]:
    return lambda tick: None if tick.estimate is None else take(tick.estimate)


def _true(take: Callable[[BodyTruth], object]) -> Callable[[Tick], object]:
    return lambda tick: None if tick.inputs.truth is None else take(tick.inputs.truth)


# What is taken of a tick, None where it is not there, and its shape; -1 is the number of legs.
_LEGS = -1
_TAKEN: Mapping[str, tuple[Callable[[Tick], object], tuple[int, ...]]] = MappingProxyType({
    "gait_phase": (lambda t: t.gait_phase, ()),
    "angle_rad": (lambda t: t.joints.angle_rad, (_LEGS,)),
    "rate_rad_s": (lambda t: t.joints.rate_rad_s, (_LEGS,)),
    "current_a": (lambda t: t.joints.current_a, (_LEGS,)),
    "temperature_c": (lambda t: t.joints.temperature_c, (_LEGS,)),
    "sent_angle_rad": (lambda t: t.sent.angle_rad, (_LEGS,)),
    "force_n": (lambda t: t.forces.force_n, (_LEGS, 3)),
    "predicted_force_n": (lambda t: t.contact.traction.force_B, (_LEGS, 3)),
    "predicted_velocity_B": (lambda t: t.contact.traction.velocity_B, (3,)),
    "predicted_slip_B": (lambda t: t.contact.traction.slip_B, (_LEGS, 2)),
    "dead_reckoning_pose": (
        lambda t: (*t.dead_reckoning.position_m, t.dead_reckoning.yaw_rad), (3,)),
    "estimate_pose": (_estimated(lambda e: (*e.position_m, e.yaw_rad)), (3,)),
    "estimate_pose_sd": (_estimated(lambda e: np.sqrt(np.diagonal(e.pose_covariance))), (3,)),
    "estimate_velocity_B": (_estimated(lambda e: e.velocity_B), (3,)),
    "estimate_force_n": (_estimated(lambda e: e.force_B), (_LEGS, 3)),
    "truth_position_W": (_true(lambda b: b.position_W), (3,)),
    "truth_quaternion_xyzw": (_true(lambda b: b.quaternion_xyzw), (4,)),
    "truth_velocity_B": (_true(lambda b: (*b.velocity_B[:2], b.angular_velocity_B[2])), (3,)),
    "truth_foot_velocity_W": (_true(lambda b: b.foot_velocity_W), (_LEGS, 3)),
    "truth_force_n": (_true(lambda b: b.foot_force_B), (_LEGS, 3)),
    "lateness_s": (lambda t: t.inputs.timing.lateness_ns * 1e-9, ()),
    "busy_s": (lambda t: t.inputs.timing.busy_ns * 1e-9, ()),
})  # fmt: skip
_COUNTED: Mapping[str, Callable[[Tick], int]] = MappingProxyType({
    "mode": lambda t: t.mode.value,
    "stop_reason": lambda t: t.stop_reason.value,
    "missed": lambda t: t.inputs.timing.missed,
    "estimate_health":
        lambda t: NOT_RUNNING if t.estimate is None else HEALTHS.index(t.estimate.health),
})  # fmt: skip


def build_recording(
    ticks: Sequence[Tick],
    *,
    names: tuple[str, ...],
    start_ns: int,
    config_text: str,
    metadata: Mapping[str, str],
    damage: str,
    times_s: Sequence[float] | None = None,
) -> Recording:
    """Stack ticks into arrays.

    Args:
        ticks: The ticks, at least one.
        names: Leg names.
        start_ns: The ticks' clock at the beginning of the log.
        config_text: The robot file.
        metadata: Metadata texts.
        damage: Empty, or how the file is damaged.
        times_s: Time of each tick since the beginning; without it, from their own clock.
    """
    arrays: dict[str, Any] = {
        "t_s": [(t.t_ns - start_ns) * 1e-9 for t in ticks] if times_s is None else times_s
    }
    for name, (take, shape) in _TAKEN.items():
        nothing = np.full([len(names) if size == _LEGS else size for size in shape], np.nan)
        taken = (take(tick) for tick in ticks)
        arrays[name] = [nothing if value is None else value for value in taken]
    arrays = {name: readonly(np.array(v, dtype=np.float64)) for name, v in arrays.items()}
    for name, count in _COUNTED.items():
        arrays[name] = readonly(np.array([count(tick) for tick in ticks], dtype=np.int64))
    truths, no_contact = [tick.inputs.truth for tick in ticks], np.zeros(len(names), dtype=bool)
    return Recording(
        names=names,
        **arrays,
        truth_contact=readonly(np.array([no_contact if b is None else b.contact for b in truths])),
        faults=tuple((row, fault) for row, tick in enumerate(ticks) for fault in tick.faults),
        config_text=config_text,
        metadata=metadata,
        damage=damage,
    )


def join_recordings(parts: Sequence[Recording], damage: str) -> Recording:
    """Put blocks of one log together, in order.

    Args:
        parts: The blocks, at least one.
        damage: How the whole is damaged, empty if it is not.
    """
    arrays: dict[str, Any] = {
        field.name: readonly(np.concatenate([getattr(part, field.name) for part in parts]))
        for field in fields(Recording)
        if isinstance(getattr(parts[0], field.name), np.ndarray)
    }
    begins = np.cumsum([0, *(len(part.t_s) for part in parts)])
    faults = tuple(
        (int(begin) + number, fault)
        for begin, part in zip(begins, parts, strict=False)
        for number, fault in part.faults
    )
    return replace(parts[-1], **arrays, faults=faults, damage=damage)


def thin_recording(log: Recording, step: int) -> Recording:
    """Return every ``step``-th tick of a log, for pictures; all faults are kept, at the ticks that are."""
    arrays: dict[str, Any] = {
        field.name: readonly(getattr(log, field.name)[::step])
        for field in fields(Recording)
        if isinstance(getattr(log, field.name), np.ndarray)
    }
    faults = tuple((number // step, fault) for number, fault in log.faults)
    return replace(log, **arrays, faults=faults)
