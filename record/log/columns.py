"""Ticks as columns of a table, by stage: what ``bigant log export`` writes.

Names follow the trial table where it has one: quantity, leg, axis, unit.
"""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.estimate import Estimate
from model.values.readings import BodyTruth
from model.values.tick import Tick
from record.log.reader import StampedTick
from record.log.tick_message import TRANSDUCERS
from record.trial.table_file import Column
from record.trial.trial import AXES, BODY_POSITION

Block = Sequence[Tick]
RAW_SERVO = (
    "position_ticks", "velocity_counts", "current_counts", "duty_counts", "voltage_counts",
    "temperature_c", "error_byte", "hardware_error", "age_ns",
)  # fmt: skip
# Upper halves of the covariances, row by row.
POSE_PAIRS = ("x_x_m2", "x_y_m2", "x_yaw_m_rad", "y_y_m2", "y_yaw_m_rad", "yaw_yaw_rad2")
TWIST_PAIRS = (
    "vx_vx_m2_s2", "vx_vy_m2_s2", "vx_yaw_rate_m_rad_s2", "vy_vy_m2_s2", "vy_yaw_rate_m_rad_s2",
    "yaw_rate_yaw_rate_rad2_s2",
)  # fmt: skip
ODOMETRY = "dead_reckoning,estimate"  # what ``odometry`` stands for in a list of groups
COUNT_AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


def table_columns(
    block: Sequence[StampedTick],
    names: tuple[str, ...],
    start_unix_ns: int,
    groups: Sequence[str],
) -> list[Column]:
    """Return time and the columns of the groups asked for.

    Args:
        block: Ticks, at least one.
        names: Leg names.
        start_unix_ns: UNIX time of 0 s.
        groups: Keys of ``GROUPS``.
    """
    unix_ns = np.array([item.unix_ns for item in block], dtype=np.int64)
    columns = [Column("time_s", (unix_ns - start_unix_ns) * 1e-9), Column("unix_ns", unix_ns)]
    ticks = [item.tick for item in block]
    for group in groups:
        columns += GROUPS[group](ticks, names)
    return columns


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


def _stack(ticks: Block, take: Callable[[Tick], object]) -> FloatArray:
    return np.array([take(tick) for tick in ticks], dtype=np.float64)


def _each(values: FloatArray, names: Sequence[str], pattern: str) -> list[Column]:
    """Name the columns of (T, N) values, a leg each."""
    return [Column(pattern.format(name), values[:, at]) for at, name in enumerate(names)]


def _axes(values: FloatArray, names: Sequence[str], pattern: str) -> list[Column]:
    """Name the columns of (T, N, A) values, a leg and an axis each."""
    return [
        Column(pattern.format(name, axis), values[:, at, k])
        for at, name in enumerate(names)
        for k, axis in enumerate(AXES[: values.shape[2]])
    ]


def _joints(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    return [
        *_each(_stack(ticks, lambda t: t.joints.angle_rad), names, "shaft_{}_rad"),
        *_each(_stack(ticks, lambda t: t.joints.rate_rad_s), names, "shaft_{}_rad_s"),
        *_each(_stack(ticks, lambda t: t.joints.current_a), names, "current_{}_a"),
        *_each(_stack(ticks, lambda t: t.joints.voltage_v), names, "voltage_{}_v"),
        *_each(_stack(ticks, lambda t: t.joints.temperature_c), names, "temperature_{}_c"),
        *_each(_stack(ticks, lambda t: t.joints.duty), names, "pwm_{}"),
    ]


def _commands(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    torque = np.array([tick.sent.torque for tick in ticks], dtype=np.int64)
    return [
        *_each(_stack(ticks, lambda t: t.wished.angle_rad), names, "wished_{}_rad"),
        *_each(_stack(ticks, lambda t: t.sent.angle_rad), names, "command_{}_rad"),
        Column("torque_on", torque),
    ]


def _forces(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    return _axes(_stack(ticks, lambda t: t.forces.force_n), names, "force_{}_{}_n")


def _model(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    velocity = _stack(ticks, lambda t: t.contact.traction.velocity_B)
    return [
        Column("predicted_velocity_x_m_s", velocity[:, 0]),
        Column("predicted_velocity_y_m_s", velocity[:, 1]),
        Column("predicted_yaw_rate_rad_s", velocity[:, 2]),
        Column("predicted_height_m", _stack(ticks, lambda t: t.contact.support.height_m)),
        Column("predicted_slope_x_rad", _stack(ticks, lambda t: t.contact.support.slope_x)),
        Column("predicted_slope_y_rad", _stack(ticks, lambda t: t.contact.support.slope_y)),
        *_axes(
            _stack(ticks, lambda t: t.contact.traction.force_B), names, "predicted_force_{}_{}_n"
        ),
        *_axes(
            _stack(ticks, lambda t: t.contact.traction.slip_B), names, "predicted_slip_{}_{}_m_s"
        ),
        *_axes(_stack(ticks, lambda t: t.feet.position_m), names, "unloaded_foot_{}_{}_m"),
    ]


def _dead_reckoning(ticks: Block, _names: tuple[str, ...]) -> list[Column]:
    pose = _stack(ticks, lambda t: (*t.dead_reckoning.position_m, t.dead_reckoning.yaw_rad))
    velocity = _stack(ticks, lambda t: t.dead_reckoning.velocity_B)
    return _planar("dead_reckoning", pose, velocity)


def _estimate(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    """What the estimator says; NaN and an empty health in ticks in which it did not run."""
    legs = len(names)

    def said(take: Callable[[Estimate], object], *shape: int) -> FloatArray:
        nothing = np.full(shape, np.nan)
        return _stack(ticks, lambda t: nothing if t.estimate is None else take(t.estimate))

    texts = np.empty((len(ticks), 2), dtype=object)
    for at, tick in enumerate(ticks):
        own = tick.estimate
        texts[at] = ("", "") if own is None else (own.health.value, own.reason)
    force_sd = said(lambda e: np.sqrt(np.diagonal(e.force_covariance, axis1=1, axis2=2)), legs, 3)
    return [
        *_planar(
            "estimate",
            said(lambda e: (*e.position_m, e.yaw_rad), 3),
            said(lambda e: e.velocity_B, 3),
        ),
        *_covariance(POSE_PAIRS, said(lambda e: e.pose_covariance, 3, 3)),
        *_covariance(TWIST_PAIRS, said(lambda e: e.twist_covariance, 3, 3)),
        *_axes(said(lambda e: e.force_B, legs, 3), names, "estimate_force_{}_{}_n"),
        *_axes(force_sd, names, "estimate_force_sd_{}_{}_n"),
        *_each(said(lambda e: e.mu, legs), names, "estimate_mu_{}"),
        *_each(said(lambda e: e.mu_sd, legs), names, "estimate_mu_log_sd_{}"),
        *_each(said(lambda e: e.stiffness, legs), names, "estimate_stiffness_{}_n_m"),
        *_each(said(lambda e: e.stiffness_sd, legs), names, "estimate_stiffness_log_sd_{}"),
        *_each(said(lambda e: e.contact, legs), names, "estimate_contact_{}"),
        *_each(said(lambda e: e.slipping, legs), names, "estimate_slipping_{}"),
        Column("estimate_height_m", said(lambda e: e.height_m)),
        Column("estimate_roll_rad", said(lambda e: e.tilt_rad[0])),
        Column("estimate_pitch_rad", said(lambda e: e.tilt_rad[1])),
        Column("estimate_nis", said(lambda e: e.nis)),
        Column("estimate_nis_dof", said(lambda e: e.nis_dof)),
        Column("estimate_rejects", said(lambda e: e.rejects)),
        Column("estimate_force_age_s", said(lambda e: e.force_age_s)),
        Column("estimate_holding", said(lambda e: e.holding)),
        Column("estimate_health", texts[:, 0]),
        Column("estimate_reason", texts[:, 1]),
    ]


def _planar(who: str, pose: FloatArray, velocity: FloatArray) -> list[Column]:
    """Name the columns of a planar pose and the body velocity, (T, 3) each."""
    place = ("x_m", "y_m", "yaw_rad")
    rates = ("velocity_x_m_s", "velocity_y_m_s", "yaw_rate_rad_s")
    return [
        *(Column(f"{who}_{name}", pose[:, k]) for k, name in enumerate(place)),
        *(Column(f"{who}_{name}", velocity[:, k]) for k, name in enumerate(rates)),
    ]


def _covariance(pairs: Sequence[str], values: FloatArray) -> list[Column]:
    """Name the columns of the upper halves of (T, 3, 3) covariances of the estimate."""
    return [
        Column(f"estimate_covariance_{pair}", values[:, row, column])
        for pair, row, column in zip(pairs, *np.triu_indices(3), strict=True)
    ]


def truth_stack(ticks: Block, take: Callable[[BodyTruth], FloatArray], *shape: int) -> FloatArray:
    """Stack something of the truth, (T, *shape); NaN in ticks without."""
    nothing = np.full(shape, np.nan)
    return _stack(ticks, lambda t: nothing if t.inputs.truth is None else take(t.inputs.truth))


def _truth(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    legs = len(names)
    place = truth_stack(ticks, lambda b: b.position_W, 3)
    turn = truth_stack(ticks, lambda b: b.quaternion_xyzw, 4)
    velocity = truth_stack(ticks, lambda b: b.velocity_B, 3)
    rates = truth_stack(ticks, lambda b: b.angular_velocity_B, 3)
    contact = truth_stack(ticks, lambda b: b.contact.astype(np.float64), legs)
    return [
        *(Column(name, place[:, k]) for k, name in enumerate(BODY_POSITION)),
        *(Column(f"body_quaternion_{c}", turn[:, k]) for k, c in enumerate("xyzw")),
        *(Column(f"body_velocity_{c}_m_s", velocity[:, k]) for k, c in enumerate(AXES)),
        *(Column(f"body_rate_{c}_rad_s", rates[:, k]) for k, c in enumerate(AXES)),
        *_axes(
            truth_stack(ticks, lambda b: b.foot_position_W, legs, 3), names, "true_foot_{}_{}_m"
        ),
        *_axes(
            truth_stack(ticks, lambda b: b.foot_velocity_W, legs, 3), names, "true_foot_{}_{}_m_s"
        ),
        *_axes(truth_stack(ticks, lambda b: b.foot_force_B, legs, 3), names, "true_force_{}_{}_n"),
        *_each(contact, names, "true_contact_{}"),
    ]


def _loop(ticks: Block, _names: tuple[str, ...]) -> list[Column]:
    texts = np.empty((len(ticks), 3), dtype=object)
    for at, tick in enumerate(ticks):
        faults = "; ".join(f"{f.kind.name} {f.source} {f.detail}" for f in tick.faults)
        texts[at] = (tick.mode.name, tick.stop_reason.name, faults)
    return [
        Column("tick", np.array([t.index for t in ticks], dtype=np.int64)),
        Column("mode", texts[:, 0]),
        Column("stop_reason", texts[:, 1]),
        Column("gait_phase", _stack(ticks, lambda t: t.gait_phase)),
        Column("lateness_s", _stack(ticks, lambda t: t.inputs.timing.lateness_ns * 1e-9)),
        Column("busy_s", _stack(ticks, lambda t: t.inputs.timing.busy_ns * 1e-9)),
        Column("missed", np.array([t.inputs.timing.missed for t in ticks], dtype=np.int64)),
        Column("faults", texts[:, 2]),
    ]


def _raw(ticks: Block, names: tuple[str, ...]) -> list[Column]:
    """Counts as the devices sent them; of several force records in one tick, the last."""
    absent = np.full(len(names), np.nan)
    columns: list[Column] = []
    for field in RAW_SERVO:

        def take(tick: Tick, field: str = field) -> FloatArray:
            servos = tick.inputs.servos
            if servos is None:
                return absent
            return np.where(servos.valid, getattr(servos, field), np.nan)

        columns += _each(_stack(ticks, take), names, f"servo_{field}_{{}}")
    no_record = np.full((TRANSDUCERS, len(COUNT_AXES)), np.nan)

    def counts(tick: Tick) -> FloatArray:
        if not tick.inputs.forces:
            return no_record
        last = tick.inputs.forces[-1]
        return np.where(last.present[:, None], last.counts, np.nan)

    values = _stack(ticks, counts)
    columns += [
        Column(f"transducer_{at + 1}_{axis}_counts", values[:, at, k])
        for at in range(TRANSDUCERS)
        for k, axis in enumerate(COUNT_AXES)
    ]
    return [*columns, Column("force_records", _stack(ticks, lambda t: len(t.inputs.forces)))]


GROUPS: Mapping[str, Callable[[Block, tuple[str, ...]], list[Column]]] = MappingProxyType(
    {
        "joints": _joints,
        "commands": _commands,
        "forces": _forces,
        "model": _model,
        "dead_reckoning": _dead_reckoning,
        "estimate": _estimate,
        "truth": _truth,
        "loop": _loop,
        "raw": _raw,
    }
)
