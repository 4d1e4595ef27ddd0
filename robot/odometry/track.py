"""The estimator over a recording, tick by tick, with only what the loop knew at each tick."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.constants import g as standard_gravity

from model.errors import ModelError
from model.estimator.filter import Estimator
from model.estimator.settings import EstimatorSettings
from model.kinematics.four_bar import Linkage
from model.parameters.robot import ContactParameters
from model.values.arrays import FloatArray, IntArray
from model.values.estimate import Estimate, EstimatorState, OdometryInputs
from model.values.legs import FootForces, FootMotion
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, eq=False)
class OdometryTrack:
    """What the estimator said over T ticks of N legs.

    Attributes:
        t_s: (T,).
        pose: x, y [m], yaw [rad], (T, 3).
        velocity_B: (T, 3).
        pose_covariance: (T, 3, 3).
        twist_covariance: (T, 3, 3).
        force_B: Predicted, (T, N, 3) [N].
        mu: (T, N).
        stiffness: (T, N) [N/m].
        nis: (T,); NaN without a measurement.
        nis_dof: (T,).
        step_us: Time of each step [us], with whatever else the machine was doing.
        cpu_us: Time of the processor that each step took [us].
        estimates: All that was said.
        states: What the estimator remembered, for smoothing; empty unless asked for.
    """

    t_s: FloatArray
    pose: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    pose_covariance: FloatArray
    twist_covariance: FloatArray
    force_B: FloatArray  # noqa: N815
    mu: FloatArray
    stiffness: FloatArray
    nis: FloatArray
    nis_dof: IntArray
    step_us: FloatArray
    cpu_us: FloatArray
    estimates: tuple[Estimate, ...]
    states: tuple[EstimatorState, ...]


def feet_of(log: Recording, config: RobotConfig) -> FootMotion:
    """Feet from shaft angles and the servos' own speeds, which need no look ahead; (T, N, 3) each."""
    parameters = config.parameters
    linkage = Linkage(parameters.linkage, parameters.legs.shaft_position)
    return linkage.feet(log.angle_rad, log.rate_rad_s)


def weight_of(config: RobotConfig) -> float:
    """Weight of the robot [N]."""
    return config.parameters.body.mass * standard_gravity


def inputs_of(log: Recording, feet: FootMotion, first: int, last: int) -> list[OdometryInputs]:
    """Inputs of ticks ``first`` to ``last``; a force equal to the one before is the same record."""
    times = np.round(log.t_s * 1e9).astype(np.int64)
    known = np.asarray(np.isfinite(log.force_n).all(axis=2))
    found, force_ns = [], -1
    for i in range(first, last):
        same = i > first and np.array_equal(log.force_n[i], log.force_n[i - 1], equal_nan=True)
        if not same and known[i].any():
            force_ns = int(times[i])
        forces = FootForces(force_ns, log.force_n[i], known[i])
        motion = FootMotion(feet.position_m[i], feet.velocity_m_s[i])
        found.append(OdometryInputs(int(times[i]), motion, forces))
    return found


def track(
    inputs: list[OdometryInputs],
    contact: ContactParameters,
    weight_n: float,
    settings: EstimatorSettings | None = None,
    *,
    pose: FloatArray | None = None,
    keep_states: bool = False,
    progress: Progress | None = None,
) -> OdometryTrack:
    """Run the estimator over inputs.

    Args:
        inputs: One a tick.
        contact: Where the parameters start.
        weight_n: [N].
        settings: Noise; the defaults if None.
        pose: x, y, yaw to start from.
        keep_states: Keep what a smoother needs.
        progress: Told the share done.

    Raises:
        ModelError: There are no inputs.
    """
    if not inputs:
        raise ModelError("there is no tick to estimate from; record a longer walk")
    estimator = Estimator(contact, weight_n, settings)
    state = estimator.initial(pose)
    said, states, spent, used = [], [], [], []
    for i, known in enumerate(inputs):
        began, cpu = time.perf_counter_ns(), time.thread_time_ns()
        state, estimate = estimator.step(state, known)
        used.append((time.thread_time_ns() - cpu) / 1e3)
        spent.append((time.perf_counter_ns() - began) / 1e3)
        said.append(estimate)
        if keep_states:
            states.append(state)
        if progress is not None and i % 200 == 0:
            progress(i / len(inputs))
    return OdometryTrack(
        t_s=np.array([e.t_ns for e in said]) * 1e-9,
        pose=np.array([[*e.position_m, e.yaw_rad] for e in said]),
        velocity_B=np.array([e.velocity_B for e in said]),
        pose_covariance=np.array([e.pose_covariance for e in said]),
        twist_covariance=np.array([e.twist_covariance for e in said]),
        force_B=np.array([e.force_B for e in said]),
        mu=np.array([e.mu for e in said]),
        stiffness=np.array([e.stiffness for e in said]),
        nis=np.array([e.nis for e in said]),
        nis_dof=np.array([e.nis_dof for e in said]),
        step_us=np.array(spent),
        cpu_us=np.array(used),
        estimates=tuple(said),
        states=tuple(states),
    )
