"""What the estimator said in a tick, and absolute poses, as parts of the tick's message.

The order of fields is that of ``bigant_msgs/msg/Estimate`` and ``PoseRecord`` in
``record.log.definitions``.
"""

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import Estimate, Health
from model.values.readings import PoseRecord
from record.log.cdr import CdrReader, CdrWriter

HEALTHS = (Health.OK, Health.DEGRADED, Health.LOST)  # codes 0, 1, 2
# a covariance is symmetric to the last bit: six of its nine numbers are kept
_ROWS, _COLUMNS = np.tril_indices(3)
_LOWER = 3 * _ROWS + _COLUMNS


def write_poses(w: CdrWriter, poses: tuple[PoseRecord, ...]) -> None:
    """Write absolute poses."""
    w.u32(len(poses))
    for pose in poses:
        w.i64(pose.t_ns)
        w.f64_array(pose.position_W)
        w.f64_array(pose.quaternion_xyzw)
        w.f64(pose.sd_position_m, pose.sd_angle_rad)


def read_poses(r: CdrReader) -> tuple[PoseRecord, ...]:
    """Read absolute poses."""
    return tuple(
        PoseRecord(r.i64(), r.f64_array(3), r.f64_array(4), r.f64(), r.f64())
        for _ in range(r.u32())
    )


def write_estimate(w: CdrWriter, said: Estimate | None) -> None:
    """Write an estimate: a sequence of one, or of none."""
    w.u32(said is not None)
    if said is None:
        return
    w.i64(said.t_ns)
    w.u8(HEALTHS.index(said.health))
    w.text(said.reason)
    w.record(
        "?qq" + 15 * "d", said.holding, said.nis_dof, said.rejects,
        *said.position_m.tolist(), said.yaw_rad, *said.velocity_B.tolist(), *said.bias_B.tolist(),
        *said.tilt_rad.tolist(), said.height_m, said.nis, said.log_likelihood, said.force_age_s,
    )  # fmt: skip
    w.f64_array(said.pose_covariance.take(_LOWER))
    w.f64_array(said.twist_covariance.take(_LOWER))
    w.f64s(
        said.mu, said.mu_sd, said.stiffness, said.stiffness_sd, said.force_B,
        said.force_covariance.reshape(-1, 9).take(_LOWER, axis=1), said.load_share,
        said.load_share_sd, said.innovation,
    )  # fmt: skip
    w.flags(said.contact)
    w.flags(said.slipping)


def read_estimate(r: CdrReader) -> Estimate | None:
    """Read an estimate, None if there is none.

    Raises:
        ValueError: The message is damaged.
    """
    if r.u32() == 0:
        return None
    t_ns, health, reason = r.i64(), HEALTHS[r.u8()], r.text()
    holding, nis_dof, rejects = r.record("?qq")
    numbers = r.f64_array(15)
    pose_covariance, twist_covariance = _square(r.f64_array(6)), _square(r.f64_array(6))
    mu, mu_sd, stiffness, stiffness_sd = r.f64_rows(4)
    force = r.f64s().reshape(-1, 3)
    force_covariance = _square(r.f64s().reshape(-1, 6))
    load_share, load_share_sd = r.f64_rows(2)
    innovation = r.f64s().reshape(-1, 3)
    return Estimate(
        t_ns=t_ns,
        position_m=numbers[0:2],
        yaw_rad=float(numbers[2]),
        velocity_B=numbers[3:6],
        pose_covariance=pose_covariance,
        twist_covariance=twist_covariance,
        bias_B=numbers[6:9],
        mu=mu,
        mu_sd=mu_sd,
        stiffness=stiffness,
        stiffness_sd=stiffness_sd,
        force_B=force,
        force_covariance=force_covariance,
        load_share=load_share,
        load_share_sd=load_share_sd,
        tilt_rad=numbers[9:11],
        height_m=float(numbers[11]),
        contact=r.flags(),
        slipping=r.flags(),
        holding=holding,
        nis=float(numbers[12]),
        nis_dof=nis_dof,
        log_likelihood=float(numbers[13]),
        innovation=innovation,
        rejects=rejects,
        force_age_s=float(numbers[14]),
        health=health,
        reason=reason,
    )


def _square(lower: FloatArray) -> FloatArray:
    """Symmetric matrices, (..., 3, 3), from their lower halves, (..., 6)."""
    full = np.empty((*lower.shape[:-1], 3, 3))
    full[..., _ROWS, _COLUMNS] = lower
    full[..., _COLUMNS, _ROWS] = lower
    return full
