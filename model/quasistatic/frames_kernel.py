"""The loop over frames, compiled: support, foot speeds, traction, frame by frame."""

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, out
from model.support.kernel import ROWS, support_kernel
from model.traction.coulomb_frame import coulomb_frame
from model.traction.kernel import foot_speeds, lay_anisotropy, traction_kernel
from model.values.arrays import BoolArray, FloatArray, IntArray

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

    Shapes are those of ``model.quasistatic.frames``; ground is (1 or F, N) and anisotropy (1 or F, N, 2).
    """
    frames, count = feet.shape[0], feet.shape[1]
    work = np.empty((ROWS, count))
    lay_anisotropy(anisotropy[0], work)
    twist = np.empty(3)
    rested = np.zeros(count, dtype=np.bool_)
    warm = False
    uneven = ground.shape[0] > 1
    turns = anisotropy.shape[0] > 1  # w of its own for every frame
    for f in range(frames):
        if turns:
            lay_anisotropy(anisotropy[f], work)
        switches[f] = 0
        unique[f] = not coulomb
        found = support_kernel(
            feet[f], ground[f if uneven else 0], stiffness, load, pose[f], loads[f], work
        )
        if found < 0:
            reason[f] = -found
            pose[f, :] = np.nan
            loads[f, :] = np.nan
        else:
            reason[f] = 0
            switches[f] = found
            if not foot_speeds(feet_velocity[f], pose[f], tilt_coupling, work):
                reason[f] = NOT_A_NUMBER
        if reason[f] == 0:
            if coulomb:
                reason[f], unique[f] = coulomb_frame(
                    work, loads[f], mu, warm, twist, slip[f], force[f], rested
                )
                sticking[f, :] = rested
            else:
                reason[f] = traction_kernel(work, loads[f], mu, twist, slip[f], force[f])
                sticking[f, :] = False
            velocity[f, :] = twist
        warm = reason[f] == 0
        if not warm:
            velocity[f, :] = np.nan
            slip[f, :, :] = np.nan
            force[f, :, :] = np.nan
            sticking[f, :] = False
            unique[f] = False


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(
        frames_kernel, *given(3, 3, 2, 1, 1, 3), NUMBER, FLAG, FLAG, *out(2, 2),
        *out(1, kind=COUNT), *out(2, 3, 3), *out(2, 1, kind=FLAG), *out(1, kind=COUNT),
    )  # fmt: skip
