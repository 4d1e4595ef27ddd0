"""A log as arrays: T ticks of N legs and J joints, for tables, plots and comparisons."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, NamedTuple, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.estimate import Estimate
from model.values.faults import Fault
from model.values.machine_names import MachineNames
from model.values.readings import ImuRecord
from model.values.tick import Tick
from record.growing_array import GrowingTable
from record.log.estimate_message import HEALTHS

NOT_RUNNING = -1
LEGS, JOINTS = -1, -2  # in a shape: as many as there are legs, or joints


@cache
def _names(path: str) -> list[str]:
    return path.split(".")


def follow(value: Any, path: str) -> Any:
    """Return what a dotted path of attributes leads to; None where one of them is None."""
    for name in _names(path):
        value = getattr(value, name)
        if value is None:
            return None
    return value


class Stack(NamedTuple):
    """Something of every tick as an array, (T, *shape).

    Attributes:
        path: Where it is in a tick.
        shape: Its shape; ``LEGS`` is the number of legs, ``JOINTS`` that of joints.
        change: What to make of it first; None where there is nothing.
        absent: Its value if there is none.
        kind: Kind of the numbers.
    """

    path: str
    shape: tuple[int, ...] = ()
    change: Callable[[Any], object] | None = None
    absent: object = np.nan
    kind: type = np.float64

    def of(self, ticks: Sequence[Any], legs: int = 0, joints: int = 0) -> NDArray[Any]:
        """Return the array of some ticks of so many legs and joints."""
        shape = self._shape(legs, joints)
        nothing = np.full(shape, self.absent, self.kind) if shape else self.absent
        values = (follow(tick, self.path) for tick in ticks)
        if self.change is not None:
            values = (None if value is None else self.change(value) for value in values)
        return np.array([nothing if value is None else value for value in values], self.kind)

    def empty(self, count: int, legs: int, joints: int) -> NDArray[Any]:
        """Return the array of so many ticks in which there is nothing of it; codes are always there."""
        if self.absent is np.nan and self.kind is not np.float64:
            return np.zeros((count, *self._shape(legs, joints)), self.kind)
        return np.full((count, *self._shape(legs, joints)), self.absent, self.kind)

    def _shape(self, legs: int, joints: int) -> tuple[int, ...]:
        sizes = {LEGS: legs, JOINTS: joints}
        return tuple(sizes.get(size, size) for size in self.shape)


def newest_imu(readings: Sequence[ImuRecord]) -> FloatArray | None:
    """Yaw rate [rad/s], roll, pitch [rad], (3,), of the newest reading; None where there is none."""
    if not readings:
        return None
    newest = readings[-1]
    return np.array([newest.yaw_rate_rad_s, newest.roll_rad, newest.pitch_rad])


def _gyro_bias(estimate: Estimate) -> tuple[float, float]:
    return estimate.gyro_bias_rad_s, estimate.gyro_bias_sd


def standard_deviations(covariance: FloatArray) -> FloatArray:
    """Return them, (..., N), of covariances, (..., N, N); NaN where damaged bytes make one negative."""
    variance = np.diagonal(covariance, axis1=-2, axis2=-1)
    with np.errstate(invalid="ignore"):
        return np.sqrt(variance)


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A log, T ticks.

    Attributes:
        names: Leg names, N of them.
        t_s: Time since the beginning, (T,).
        mode: Mode codes, (T,).
        stop_reason: Stop reason codes, (T,).
        gait_phase: (T,) [cycles]; NaN when no gait runs.
        angle_rad: Measured shaft angles, (T, J).
        rate_rad_s: Measured shaft speeds, (T, J).
        current_a: Motor currents, (T, J).
        temperature_c: Servo temperatures, (T, J).
        sent_angle_rad: Angles sent, (T, J); NaN while torque is off.
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
        gyro_bias: The estimated bias of the yaw gyro and its sd [rad/s], (T, 2); NaN without a gyro.
        imu: The newest reading of the IMU in a tick, in its own axes: yaw rate [rad/s], roll, pitch [rad],
            (T, 3); NaN where none came.
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
        joints: Joint names, J of them.
    """

    names: tuple[str, ...]
    t_s: FloatArray
    mode: Annotated[IntArray, Stack("mode.value", kind=np.int64)]
    stop_reason: Annotated[IntArray, Stack("stop_reason.value", kind=np.int64)]
    gait_phase: Annotated[FloatArray, Stack("gait_phase")]
    angle_rad: Annotated[FloatArray, Stack("joints.angle_rad", (JOINTS,))]
    rate_rad_s: Annotated[FloatArray, Stack("joints.rate_rad_s", (JOINTS,))]
    current_a: Annotated[FloatArray, Stack("joints.current_a", (JOINTS,))]
    temperature_c: Annotated[FloatArray, Stack("joints.temperature_c", (JOINTS,))]
    sent_angle_rad: Annotated[FloatArray, Stack("sent.angle_rad", (JOINTS,))]
    force_n: Annotated[FloatArray, Stack("forces.force_n", (LEGS, 3))]
    predicted_force_n: Annotated[FloatArray, Stack("contact.traction.force_B", (LEGS, 3))]
    predicted_velocity_B: Annotated[FloatArray, Stack("contact.traction.velocity_B", (3,))]  # noqa: N815
    predicted_slip_B: Annotated[FloatArray, Stack("contact.traction.slip_B", (LEGS, 2))]  # noqa: N815
    dead_reckoning_pose: Annotated[FloatArray, Stack("dead_reckoning.pose", (3,))]
    estimate_pose: Annotated[FloatArray, Stack("estimate.pose", (3,))]
    estimate_pose_sd: Annotated[
        FloatArray, Stack("estimate.pose_covariance", (3,), standard_deviations)
    ]
    estimate_velocity_B: Annotated[FloatArray, Stack("estimate.velocity_B", (3,))]  # noqa: N815
    estimate_force_n: Annotated[FloatArray, Stack("estimate.force_B", (LEGS, 3))]
    estimate_health: Annotated[
        IntArray, Stack("estimate.health", change=HEALTHS.index, absent=NOT_RUNNING, kind=np.int64)
    ]
    gyro_bias: Annotated[FloatArray, Stack("estimate", (2,), _gyro_bias)]
    imu: Annotated[FloatArray, Stack("inputs.imu", (3,), newest_imu)]
    truth_position_W: Annotated[FloatArray, Stack("inputs.truth.position_W", (3,))]  # noqa: N815
    truth_quaternion_xyzw: Annotated[FloatArray, Stack("inputs.truth.quaternion_xyzw", (4,))]
    truth_velocity_B: Annotated[FloatArray, Stack("inputs.truth.planar_velocity_B", (3,))]  # noqa: N815
    truth_foot_velocity_W: Annotated[FloatArray, Stack("inputs.truth.foot_velocity_W", (LEGS, 3))]  # noqa: N815
    truth_force_n: Annotated[FloatArray, Stack("inputs.truth.foot_force_B", (LEGS, 3))]
    truth_contact: Annotated[
        BoolArray, Stack("inputs.truth.contact", (LEGS,), absent=False, kind=bool)
    ]
    lateness_s: Annotated[
        FloatArray, Stack("inputs.timing.lateness_ns", change=lambda ns: ns * 1e-9)
    ]
    busy_s: Annotated[FloatArray, Stack("inputs.timing.busy_ns", change=lambda ns: ns * 1e-9)]
    missed: Annotated[IntArray, Stack("inputs.timing.missed", kind=np.int64)]
    faults: tuple[tuple[int, Fault], ...]
    config_text: str
    metadata: Mapping[str, str]
    damage: str
    joints: tuple[str, ...]

    @property
    def has_truth(self) -> bool:
        """Whether there is ground truth anywhere."""
        return bool(np.isfinite(self.truth_position_W).any())


# By field, what is stacked of the ticks.
STACKS: Mapping[str, Stack] = {
    name: kind.__metadata__[0]
    for name, kind in get_type_hints(Recording, include_extras=True).items()
    if get_origin(kind) is Annotated
}
ARRAYS = ("t_s", *STACKS)


def build_recording(
    ticks: Sequence[Tick],
    *,
    machine: MachineNames,
    start_ns: int,
    config_text: str,
    metadata: Mapping[str, str],
    damage: str,
    times_s: Sequence[float] | None = None,
) -> Recording:
    """Stack ticks into arrays.

    Args:
        ticks: The ticks, at least one.
        machine: Names of joints and legs.
        start_ns: The ticks' clock at the beginning of the log.
        config_text: The robot file.
        metadata: Metadata texts.
        damage: Empty, or how the file is damaged.
        times_s: Time of each tick since the beginning; without it, from their own clock.
    """
    arrays: dict[str, Any] = {
        "t_s": [(t.t_ns - start_ns) * 1e-9 for t in ticks] if times_s is None else times_s
    }
    arrays |= {
        name: taken.of(ticks, len(machine.legs), len(machine.joints))
        for name, taken in STACKS.items()
    }
    faults = tuple((row, fault) for row, tick in enumerate(ticks) for fault in tick.faults)
    return recording_of(
        arrays, faults, machine=machine, config_text=config_text, metadata=metadata, damage=damage
    )


def recording_of(
    arrays: Mapping[str, Any],
    faults: tuple[tuple[int, Fault], ...],
    *,
    machine: MachineNames,
    config_text: str,
    metadata: Mapping[str, str],
    damage: str,
) -> Recording:
    """Return a recording of arrays.

    Args:
        arrays: ``t_s`` and what ``STACKS`` names, a row a tick; not to be written to from then on.
        faults: Row, and fault; in order.
        machine: Names of joints and legs.
        config_text: The robot file.
        metadata: Metadata texts.
        damage: Empty, or how the file is damaged.
    """
    return Recording(
        names=machine.legs,
        **{name: readonly(np.asarray(values)) for name, values in arrays.items()},
        faults=faults,
        config_text=config_text,
        metadata=metadata,
        damage=damage,
        joints=machine.joints,
    )


class GrowingRecording:
    """Blocks of one log, put together as they come; nothing but the newest is in memory twice."""

    def __init__(self) -> None:
        self._fields = GrowingTable()
        self._faults: list[tuple[int, Fault]] = []
        self._last: Recording | None = None

    def add(self, part: Recording) -> None:
        """Add the next block."""
        ticks = len(self._fields)
        self._fields.extend({name: getattr(part, name) for name in ARRAYS})
        self._faults += ((ticks + number, fault) for number, fault in part.faults)
        self._last = part

    def recording(self, damage: str) -> Recording:
        """Return the whole so far, of at least one block.

        ``damage`` says how the whole is damaged; it is empty if it is not.
        """
        if self._last is None:
            raise ValueError("a recording has at least one block")
        fields = self._fields.arrays()
        joined: dict[str, Any] = {name: readonly(values) for name, values in fields.items()}
        return replace(self._last, **joined, faults=tuple(self._faults), damage=damage)


def join_recordings(parts: Iterable[Recording], damage: str) -> Recording:
    """Put blocks of one log together, in order.

    Args:
        parts: The blocks, at least one.
        damage: How the whole is damaged, empty if it is not.
    """
    whole = GrowingRecording()
    for part in parts:
        whole.add(part)
    return whole.recording(damage)


def thin_recording(log: Recording, step: int) -> Recording:
    """Return every ``step``-th tick of a log, for pictures; all faults are kept, at the ticks that are."""
    if step == 1:
        return log
    faults = tuple((number // step, fault) for number, fault in log.faults)
    # copies: a view would keep all that is left out in memory
    return replace(
        log, **_each_array(lambda name: getattr(log, name)[::step].copy()), faults=faults
    )


def _each_array(make: Callable[[str], NDArray[Any]]) -> dict[str, Any]:
    return {name: readonly(make(name)) for name in ARRAYS}
