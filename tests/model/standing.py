"""Made-up poses of a standing robot with sensors of known faults, for tests."""

import numpy as np

from model.fit.cross_talk import SensorPlaces, StillPoses
from model.values.arrays import BoolArray, FloatArray
from model.values.force_calibration import ForceCalibration, fourier_rows

LEGS = ("HL", "ML", "FL", "HR", "MR", "FR")
WEIGHT_N = 63.7
ORIGIN = np.array(
    [[x, y, 0.0] for y in (0.25, -0.25) for x in (-0.2, 0.0, 0.2)]
)  # the centre of mass is at the origin


def places(yaw: float = 0.3) -> SensorPlaces:
    return SensorPlaces(ORIGIN, np.full(6, yaw), WEIGHT_N)


def true_faults(random: np.random.Generator, harmonics: int = 1) -> ForceCalibration:
    """Offsets of newtons, gravity of a leg of some 0.1 kg, cross-talk of a few per cent."""
    size = np.array([3.0, 3.0, 5.0, 0.1, 0.1, 0.1])
    unloaded = np.zeros((6, 6, 1 + 2 * harmonics))
    unloaded[:, :, 0] = size * random.standard_normal((6, 6))
    unloaded[:, 4, 1:] = 0.05 * random.standard_normal((6, 2 * harmonics))
    unloaded[:, 0, 1:] = 0.2 * random.standard_normal((6, 2 * harmonics))
    load = np.array([8.0, 8.0, 8.0, 1.0, 1.0, 1.0])
    correction = 0.03 * random.standard_normal((6, 6, 6)) * load[:, None] / load[None, :]
    return ForceCalibration(
        LEGS, ("",) * 6, unloaded, correction, np.zeros((6, 6)), "in-situ", "", ()
    )


def true_wrenches(
    random: np.random.Generator, poses: int, yaw: float = 0.3
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """A robot at rest: shaft angles, wrenches, legs in the air, levers; sensor axes."""
    angle = random.uniform(-0.9, 0.9, (poses, 6))
    in_air = np.zeros((poses, 6), dtype=bool)
    for index in range(poses):
        if index % 2:
            leg = (index // 2) % 6
            in_air[index, leg] = True
            angle[index, leg] = random.uniform(-np.pi, np.pi)
    wrench = np.zeros((poses, 6, 6))
    lever = np.zeros((poses, 6, 3))
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    for index in range(poses):
        down = np.stack([-0.1 * np.sin(angle[index]), random.uniform(-0.02, 0.02, 6),
                         np.full(6, -0.15)], axis=1)  # fmt: skip
        feet = ORIGIN + down
        on = ~in_air[index]
        # any forces, then the least change that makes them balance the weight
        force = random.uniform(-6, 6, (6, 3)) * on[:, None]
        force[:, 2] = np.abs(force[:, 2]) + 5.0 * on
        rows = np.zeros((6, 18))
        for leg in np.flatnonzero(on).tolist():
            x, y, z = feet[leg]
            rows[:3, 3 * leg : 3 * leg + 3] = np.eye(3)
            rows[3:, 3 * leg : 3 * leg + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        missing = np.array([0, 0, WEIGHT_N, 0, 0, 0]) - rows @ force.ravel()
        force += (np.linalg.pinv(rows) @ missing).reshape(6, 3)
        wrench[index, :, :3] = force @ turn
        wrench[index, :, 3:] = np.cross(down, force) @ turn
        lever[index] = down @ turn
    return angle, wrench, in_air, lever


def sensed(
    faults: ForceCalibration, angle: FloatArray, wrench: FloatArray, noise: FloatArray
) -> FloatArray:
    """What sensors with these faults read."""
    cross_talk = np.linalg.inv(np.eye(6) + faults.correction)
    rows = fourier_rows(angle, faults.harmonics)
    free: FloatArray = np.einsum("nij,pnj->pni", cross_talk, wrench)
    free += np.einsum("pnh,nah->pna", rows, faults.unloaded) + noise
    return free


def still(angle: FloatArray, read: FloatArray, in_air: BoolArray, lever: FloatArray) -> StillPoses:
    up = np.tile([0.0, 0.0, 1.0], (len(angle), 1))
    return StillPoses(angle, read, in_air, up, np.ones(len(angle), dtype=bool), lever)
