"""Ticks as columns of a table, by stage: what ``bigant log export`` writes.

Names follow the trial table where it has one: quantity, leg, axis, unit.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.faults import Fault
from model.values.machine_names import MachineNames
from model.values.readings import ForceRecord, ServoReadings
from record.log.reader import StampedTick
from record.log.recording import Stack, newest_imu, standard_deviations
from record.log.tick_message import TRANSDUCERS
from record.trial.table_file import Names, TableColumn, axis_words, column_names
from record.trial.trial import BODY_POSITION, IMU

ODOMETRY = "dead_reckoning,estimate"  # what ``odometry`` stands for in a list of groups
RAW_SERVO = (
    "position_ticks", "velocity_counts", "current_counts", "duty_counts", "voltage_counts",
    "temperature_c", "error_byte", "hardware_error", "age_ns",
)  # fmt: skip
COUNT_AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


class Part(NamedTuple):
    """One column, or several alike.

    Attributes:
        names: Its name, or a pattern of names; see ``column_names``.
        path: Where the values are in a tick.
        change: What to make of them first; None where there is nothing.
        kind: Kind of the column.
    """

    names: Names
    path: str
    change: Callable[[Any], object] | None = None
    kind: type = np.float64

    def columns(self, ticks: Sequence[Any], machine: MachineNames) -> list[TableColumn]:
        """Return the columns; what is absent is NaN, or an empty text."""
        absent = "" if self.kind is object else np.nan
        shape = tuple(map(len, axis_words(self.names, machine)))
        values = Stack(self.path, shape, self.change, absent, self.kind)
        return named(self.names, values.of(ticks), machine)


def named(names: Names, values: NDArray[Any], machine: MachineNames) -> list[TableColumn]:
    """Return the columns of (T, ...) values, named as in ``Part``."""
    each = values.reshape(len(values), -1).T
    return [TableColumn(*one) for one in zip(column_names(names, machine), each, strict=True)]


def _planar(who: str, path: str) -> tuple[Part, ...]:
    """Columns of a planar pose and the body's velocity."""
    return (
        Part((f"{who}_x_m", f"{who}_y_m", f"{who}_yaw_rad"), f"{path}.pose"),
        Part(_velocity(who), f"{path}.velocity_B"),
    )


def _velocity(who: str) -> tuple[str, ...]:
    return (f"{who}_velocity_x_m_s", f"{who}_velocity_y_m_s", f"{who}_yaw_rate_rad_s")


def _covariance(path: str, *units: str) -> Part:
    """The upper half of a covariance, row by row."""
    names = tuple(f"estimate_covariance_{unit}" for unit in units)
    return Part(names, path, lambda covariance: covariance[np.triu_indices(3)])


def _seconds(time_ns: int) -> float:
    return time_ns * 1e-9


def _words(faults: Sequence[Fault]) -> str:
    return "; ".join(f"{fault.kind.name} {fault.source} {fault.detail}" for fault in faults)


def _raw_servo(field: str) -> Part:
    def values(servos: ServoReadings) -> FloatArray:
        return np.where(servos.valid, getattr(servos, field), np.nan)

    return Part(f"servo_{field}_{{joint}}", "inputs.servos", values)


def _last_counts(records: Sequence[ForceRecord]) -> FloatArray | None:
    """Of several force records in one tick the last."""
    if not records:
        return None
    return np.where(records[-1].present[:, None], records[-1].counts, np.nan).ravel()


GROUPS: Mapping[str, tuple[Part, ...]] = MappingProxyType(
    {
        "joints": (
            Part("shaft_{joint}_rad", "joints.angle_rad"),
            Part("shaft_{joint}_rad_s", "joints.rate_rad_s"),
            Part("current_{joint}_a", "joints.current_a"),
            Part("voltage_{joint}_v", "joints.voltage_v"),
            Part("temperature_{joint}_c", "joints.temperature_c"),
            Part("pwm_{joint}", "joints.duty"),
        ),
        "commands": (
            Part("wished_{joint}_rad", "wished.angle_rad"),
            Part("command_{joint}_rad", "sent.angle_rad"),
            Part("torque_on", "sent.torque", kind=np.int64),
        ),
        "forces": (Part("force_{leg}_{xyz}_n", "forces.force_n"),),
        "model": (
            Part(_velocity("predicted"), "contact.traction.velocity_B"),
            Part("predicted_height_m", "contact.support.height_m"),
            Part("predicted_slope_x_rad", "contact.support.slope_x"),
            Part("predicted_slope_y_rad", "contact.support.slope_y"),
            Part("predicted_force_{leg}_{xyz}_n", "contact.traction.force_B"),
            Part("predicted_slip_{leg}_{xy}_m_s", "contact.traction.slip_B"),
            Part("unloaded_foot_{leg}_{xyz}_m", "feet.position_m"),
        ),
        "dead_reckoning": _planar("dead_reckoning", "dead_reckoning"),
        "estimate": (
            *_planar("estimate", "estimate"),
            _covariance(
                "estimate.pose_covariance",
                "x_x_m2", "x_y_m2", "x_yaw_m_rad", "y_y_m2", "y_yaw_m_rad", "yaw_yaw_rad2",
            ),
            _covariance(
                "estimate.twist_covariance",
                "vx_vx_m2_s2", "vx_vy_m2_s2", "vx_yaw_rate_m_rad_s2", "vy_vy_m2_s2",
                "vy_yaw_rate_m_rad_s2", "yaw_rate_yaw_rate_rad2_s2",
            ),
            Part("estimate_force_{leg}_{xyz}_n", "estimate.force_B"),
            Part("estimate_force_sd_{leg}_{xyz}_n", "estimate.force_covariance", standard_deviations),
            Part("estimate_mu_{leg}", "estimate.mu"),
            Part("estimate_mu_log_sd_{leg}", "estimate.mu_sd"),
            Part("estimate_stiffness_{leg}_n_m", "estimate.stiffness"),
            Part("estimate_stiffness_log_sd_{leg}", "estimate.stiffness_sd"),
            Part("estimate_contact_{leg}", "estimate.contact"),
            Part("estimate_slipping_{leg}", "estimate.slipping"),
            Part("estimate_height_m", "estimate.height_m"),
            Part(("estimate_roll_rad", "estimate_pitch_rad"), "estimate.tilt_rad"),
            Part("estimate_nis", "estimate.nis"),
            Part("estimate_nis_dof", "estimate.nis_dof"),
            Part("estimate_rejects", "estimate.rejects"),
            Part("estimate_force_age_s", "estimate.force_age_s"),
            Part("estimate_holding", "estimate.holding"),
            Part("estimate_health", "estimate.health.value", kind=object),
            Part("estimate_reason", "estimate.reason", kind=object),
        ),
        "imu": (
            Part(IMU, "inputs.imu", newest_imu),
            Part("imu_age_s", "imu_age_s"),
            Part("imu_readings", "inputs.imu", len),
            Part("estimate_gyro_bias_rad_s", "estimate.gyro_bias_rad_s"),
            Part("estimate_gyro_bias_sd_rad_s", "estimate.gyro_bias_sd"),
        ),
        "truth": (
            Part(BODY_POSITION, "inputs.truth.position_W"),
            Part("body_quaternion_{xyzw}", "inputs.truth.quaternion_xyzw"),
            Part("body_velocity_{xyz}_m_s", "inputs.truth.velocity_B"),
            Part("body_rate_{xyz}_rad_s", "inputs.truth.angular_velocity_B"),
            Part("true_foot_{leg}_{xyz}_m", "inputs.truth.foot_position_W"),
            Part("true_foot_{leg}_{xyz}_m_s", "inputs.truth.foot_velocity_W"),
            Part("true_force_{leg}_{xyz}_n", "inputs.truth.foot_force_B"),
            Part("true_contact_{leg}", "inputs.truth.contact"),
        ),
        "loop": (
            Part("tick", "index", kind=np.int64),
            Part("mode", "mode.name", kind=object),
            Part("stop_reason", "stop_reason.name", kind=object),
            Part("gait_phase", "gait_phase"),
            Part("lateness_s", "inputs.timing.lateness_ns", _seconds),
            Part("busy_s", "inputs.timing.busy_ns", _seconds),
            Part("missed", "inputs.timing.missed", kind=np.int64),
            Part("faults", "faults", _words, kind=object),
        ),
        # counts as the devices sent them
        "raw": (
            *map(_raw_servo, RAW_SERVO),
            Part(
                tuple(
                    f"transducer_{at + 1}_{axis}_counts"
                    for at in range(TRANSDUCERS)
                    for axis in COUNT_AXES
                ),
                "inputs.forces",
                _last_counts,
            ),
            Part("force_records", "inputs.forces", len),
        ),
    }
)  # fmt: skip


# What a trial has of it; body angles and feet in the body have to be worked out.
TRIAL_PARTS = (
    *GROUPS["joints"],
    Part("command_{joint}_rad", "sent.angle_rad"),
    *GROUPS["forces"],
    Part(BODY_POSITION, "inputs.truth.position_W"),
    Part(IMU, "inputs.imu", newest_imu),
)


def table_columns(
    block: Sequence[StampedTick],
    machine: MachineNames,
    start_unix_ns: int,
    parts: Iterable[Part],
) -> list[TableColumn]:
    """Return time, UNIX time and the columns asked for.

    Args:
        block: Ticks, at least one.
        machine: Names of joints and legs.
        start_unix_ns: UNIX time of 0 s.
        parts: Some of ``GROUPS``.
    """
    unix_ns = np.array([item.unix_ns for item in block], dtype=np.int64)
    columns = [
        TableColumn("time_s", (unix_ns - start_unix_ns) * 1e-9),
        TableColumn("unix_ns", unix_ns),
    ]
    ticks = [item.tick for item in block]
    return columns + [column for part in parts for column in part.columns(ticks, machine)]


def check_groups(text: str) -> tuple[str, ...]:
    """Return the groups in a list with commas.

    Raises:
        ConfigError: One is not known.
    """
    words = (word.strip() for word in text.replace("odometry", ODOMETRY).split(","))
    groups = tuple(dict.fromkeys(word for word in words if word))
    unknown = [group for group in groups if group not in GROUPS]
    if unknown or not groups:
        raise ConfigError(
            "--what",
            f"{text!r}: choose from {', '.join(GROUPS)}, odometry (dead_reckoning and estimate), "
            "separated by commas",
        )
    return groups
