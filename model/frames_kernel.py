"""The loop over frames, compiled: support, foot speeds, traction, frame by frame."""

import numpy as np

from model.compiled import compiled
from model.coulomb_frame import coulomb_frame
from model.signals import BoolArray, FloatArray, IntArray
from model.support_kernel import support_kernel
from model.traction_kernel import foot_speeds, traction_kernel

NOT_A_NUMBER = 1


@compiled
def frames_kernel(
    feet: FloatArray,
    feet_velocity: FloatArray,
    ground: FloatArray,
    stiffness: FloatArray,
    mu: FloatArray,
    anisotropy: FloatArray,
    load: float,
    coulomb: bool,
    tilt_coupling: bool,
    pose: FloatArray,
    loads: FloatArray,
    switches: IntArray,
    velocity: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    sticking: BoolArray,
    unique: BoolArray,
    reason: IntArray,
) -> None:
    """Solve frames in order; outputs are written.

    Shapes are those of ``model.frames``; anisotropy is (1 or F, N, 2).
    """
    frames, count = feet.shape[0], feet.shape[1]
    work = np.empty((6, count))
    speed = np.empty((count, 2))
    twist = np.empty(3)
    rested = np.zeros(count, dtype=np.bool_)
    warm = False
    turns = anisotropy.shape[0] > 1  # w of its own for every frame
    for f in range(frames):
        w = anisotropy[f if turns else 0]
        switches[f] = 0
        unique[f] = not coulomb
        found = support_kernel(feet[f], ground[f], stiffness, load, pose[f], loads[f], work)
        if found < 0:
            reason[f] = -found
            pose[f, :] = np.nan
            loads[f, :] = np.nan
        else:
            reason[f] = 0
            switches[f] = found
            if not foot_speeds(feet_velocity[f], pose[f], tilt_coupling, speed):
                reason[f] = NOT_A_NUMBER
        if reason[f] == 0:
            if coulomb:
                reason[f], unique[f] = coulomb_frame(
                    feet[f],
                    speed,
                    loads[f],
                    mu,
                    w,
                    warm,
                    twist,
                    slip[f],
                    force[f],
                    rested,
                    work,
                )
                sticking[f, :] = rested
            else:
                reason[f] = traction_kernel(
                    feet[f], speed, loads[f], mu, w, twist, slip[f], force[f], work
                )
                sticking[f, :] = False
            velocity[f, :] = twist
        warm = reason[f] == 0
        if not warm:
            velocity[f, :] = np.nan
            slip[f, :, :] = np.nan
            force[f, :, :] = np.nan
            sticking[f, :] = False
            unique[f] = False
