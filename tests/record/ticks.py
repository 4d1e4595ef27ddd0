"""Made-up ticks with every corner of the type in them."""

from functools import lru_cache

import numpy as np

from model.values.arrays import readonly
from model.values.contact import ContactSolution, Support, Traction
from model.values.estimate import Estimate, Health
from model.values.faults import Fault, FaultKind, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.readings import BodyTruth, ForceRecord, ImuRecord, PoseRecord, ServoReadings
from model.values.tick import DeadReckoning, Inputs, Intent, LoopTiming, Mode, Request, Tick

NAMES = ("HL", "ML", "FL", "HR", "MR", "FR")
PERIOD_NS = 10_000_000


@lru_cache(maxsize=1024)
def make_tick(index: int, *, legs: int = 6, seed: int = 0) -> Tick:
    """A tick full of random numbers; which parts are absent depends on its index.

    Each is made once; its arrays cannot be written to.
    """
    rng = np.random.default_rng([seed, index])

    def floats(*shape: int) -> np.ndarray:
        values = rng.normal(size=shape)
        values[rng.random(shape) < 0.1] = np.nan
        return readonly(values)

    def counts(*shape: int) -> np.ndarray:
        return readonly(rng.integers(-(2**40), 2**40, shape))

    def flags(*shape: int) -> np.ndarray:
        return readonly(rng.random(shape) < 0.5)

    t_ns = 1_000_000_000 + index * PERIOD_NS
    faults = tuple(
        Fault(list(FaultKind)[(index + k) % len(FaultKind)], "HL", f"text {k} ä ü")
        for k in range(index % 3)
    )
    servos = ServoReadings(t_ns, *(counts(legs) for _ in range(8)), flags(legs), counts(legs))  # type: ignore[call-arg]
    records = tuple(
        ForceRecord(t_ns, 7, 2**32 - 1, counts(2), 5, 63, counts(6, 6), flags(6), flags(6))
        for _ in range(index % 3)
    )
    truth = BodyTruth(
        t_ns, floats(3), floats(4), floats(3), floats(3), floats(legs, 3), floats(legs, 3),
        floats(legs, 3), flags(legs),
    )  # fmt: skip
    inputs = Inputs(
        servos=None if index % 5 == 4 else servos,
        forces=records,
        request=Request(Intent.WALK, "tripod", 0.1, -0.25, StopReason.NONE),
        timing=LoopTiming(t_ns, 123, 0, 4567),
        truth=None if index % 4 == 3 else truth,
        faults=faults[:1],
        poses=tuple(
            PoseRecord(t_ns - k, floats(3), floats(4), 0.002, np.nan) for k in range(index % 2)
        ),
        imu=tuple(
            ImuRecord(t_ns - k, *rng.normal(size=3).tolist()) for k in range((index + 1) % 3)
        ),
    )
    command = JointCommand(t_ns, floats(legs), floats(legs), torque=True)
    return Tick(
        t_ns=t_ns,
        index=index,
        mode=list(Mode)[index % len(Mode)],
        stop_reason=StopReason.NONE,
        inputs=inputs,
        joints=JointState(t_ns, *(floats(legs) for _ in range(6)), valid=flags(legs)),  # type: ignore[misc]
        forces=FootForces(t_ns, floats(legs, 3), flags(legs)),
        gait_phase=np.nan if index % 2 else 0.01 * index,
        wished=command,
        sent=command,
        feet=FootMotion(floats(legs, 3), floats(legs, 3)),
        contact=ContactSolution(
            Support(True, "", 0.1, 0.01, -0.02, floats(legs), flags(legs), 3),
            Traction(False, "why not", floats(3), floats(legs, 2), floats(legs, 3)),
        ),
        dead_reckoning=DeadReckoning(t_ns, rng.normal(size=2), 0.5, rng.normal(size=3), valid=True),
        faults=faults,
        estimate=None if index % 3 == 2 else make_estimate(rng, t_ns, legs),
    )


def make_estimate(rng: np.random.Generator, t_ns: int, legs: int) -> Estimate:
    """An estimate full of random numbers; its covariances are symmetric, as all of them are."""

    def symmetric(*shape: int) -> np.ndarray:
        half = rng.normal(size=(*shape, 3, 3))
        square = half @ np.swapaxes(half, -1, -2)
        return readonly(square + np.swapaxes(square, -1, -2))

    def floats(*shape: int) -> np.ndarray:
        return readonly(rng.normal(size=shape))

    return Estimate(
        t_ns=t_ns, position_m=floats(2), yaw_rad=0.25, velocity_B=floats(3),
        pose_covariance=symmetric(), twist_covariance=symmetric(), bias_B=floats(3),
        mu=floats(legs), mu_sd=floats(legs), stiffness=floats(legs), stiffness_sd=floats(legs),
        force_B=floats(legs, 3), force_covariance=symmetric(legs), load_share=floats(legs),
        load_share_sd=floats(legs), tilt_rad=floats(2), height_m=0.1,
        contact=rng.random(legs) < 0.5, slipping=rng.random(legs) < 0.5, holding=True, nis=np.nan,
        nis_dof=7, log_likelihood=-3.5, innovation=np.full((legs, 3), np.nan), rejects=3,
        force_age_s=0.01, health=Health.DEGRADED, reason="no forces for 0.6 s",
        gyro_bias_rad_s=0.01, gyro_bias_sd=0.001, companion_pose=np.empty((0, 3)), source_nis=floats(5),
        source_dof=np.arange(5), noise_scale=floats(5), remark="the ground rises",
    )  # fmt: skip
