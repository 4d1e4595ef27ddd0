"""A trotting quadruped of the size of a Ghost Robotics Spirit 40: where momentum begins to matter.

The model has no inertia, so its velocity changes at once when a foot lands. As in the paper a first
order low pass on the predicted velocity stands in for the body's mass.
"""

import numpy as np

from model.systems.foot_path import walk
from model.systems.system import RATE_HZ, System, box, equal_contacts
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY

FRAMES, CYCLES = 921, 9.0  # the paper's recording
FREQUENCY_HZ = CYCLES * RATE_HZ / FRAMES
LOW_PASS = 0.15  # the paper's, chosen by hand
# Roughly a Spirit 40; assumed.
MASS_KG = 12.0
HIP_X_M, HIP_Y_M, FOOT_Y_M, STANCE_M = 0.226, 0.07, 0.171, 0.28
BODY_LENGTH_M, BODY_WIDTH_M = 0.50, 0.20
STIFFNESS_N_M, MU = 8000.0, 0.8
# Hind left, front left, hind right, front right; legs across from each other move together.
AHEAD = np.array([-1.0, 1.0, -1.0, 1.0])
LEFT = np.array([1.0, 1.0, -1.0, -1.0])
DELAY = np.array([0.5, 0.0, 0.0, 0.5])


def quadruped(frames: int = FRAMES) -> System:
    """A quadruped that trots straight ahead. Foot order: HL, FL, HR, FR.

    Args:
        frames: Number of frames.

    Raises:
        ModelError: Too few frames.
    """
    time_s: FloatArray = np.arange(frames) / RATE_HZ
    rest = np.column_stack([HIP_X_M * AHEAD, FOOT_Y_M * LEFT, np.full(4, -STANCE_M)])
    phase = FREQUENCY_HZ * time_s[:, None] - DELAY
    return System(
        name="quadruped",
        description=f"trotting quadruped, {FREQUENCY_HZ:.2f} Hz",
        time_s=time_s,
        feet=walk(rest, phase, FREQUENCY_HZ, stroke_m=0.16, lift_m=0.05, duty=0.55),
        contact=equal_contacts(4, STIFFNESS_N_M, MU),
        weight_n=MASS_KG * STANDARD_GRAVITY,
        low_pass=LOW_PASS,
        outline_B=box(BODY_LENGTH_M, BODY_WIDTH_M),
        hips_B=np.column_stack([HIP_X_M * AHEAD, HIP_Y_M * LEFT]),
    )
