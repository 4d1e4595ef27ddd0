"""A trotting quadruped of the size of a Ghost Robotics Spirit 40: where momentum begins to matter.

The model has no inertia, so its velocity changes at once when a foot lands. As in the paper a first
order low pass on the predicted velocity stands in for the body's mass.
"""

import numpy as np
from scipy.constants import g as standard_gravity

from model.systems.foot_path import FootPath, walk
from model.systems.system import System, box, equal_contacts
from model.values.arrays import FloatArray

FRAMES, RATE_HZ, CYCLES = 921, 100.0, 9.0  # the paper's recording
LOW_PASS = 0.15  # the paper's, chosen by hand
# Roughly a Spirit 40; assumed.
MASS_KG = 12.0
HIP_X_M, HIP_Y_M, FOOT_Y_M, STANCE_M = 0.226, 0.07, 0.171, 0.28
BODY_LENGTH_M, BODY_WIDTH_M = 0.50, 0.20
# Hind left, front left, hind right, front right; legs across from each other move together.
DELAY = (0.5, 0.0, 0.0, 0.5)


def quadruped(
    *,
    frames: int = FRAMES,
    rate_hz: float = RATE_HZ,
    frequency_hz: float = CYCLES * RATE_HZ / FRAMES,
    stroke_m: float = 0.16,
    lift_m: float = 0.05,
    duty: float = 0.55,
    stiffness: float = 8000.0,
    mu: float = 0.8,
    low_pass: float | None = LOW_PASS,
) -> System:
    """A quadruped that trots straight ahead. Foot order: HL, FL, HR, FR.

    Args:
        frames: Number of frames.
        rate_hz: Frames a second.
        frequency_hz: Gait cycles a second.
        stroke_m: Way of each foot in stance [m].
        lift_m: How high feet are lifted [m].
        duty: Stance share of the cycle.
        stiffness: Of each leg [N/m].
        mu: Friction coefficient.
        low_pass: Coefficient of the low pass on the predicted velocity, or None for none.

    Raises:
        ModelError: Values that make no gait.
    """
    time_s: FloatArray = np.arange(frames) / rate_hz
    ahead = np.array([-1.0, 1.0, -1.0, 1.0])
    left = np.array([1.0, 1.0, -1.0, -1.0])
    rest = np.column_stack([HIP_X_M * ahead, FOOT_Y_M * left, np.full(4, -STANCE_M)])
    phase = frequency_hz * time_s[:, None] - np.array(DELAY)
    return System(
        name="quadruped",
        description=f"trotting quadruped, {frequency_hz:.2f} Hz",
        time_s=time_s,
        feet=walk(FootPath(stroke_m, lift_m, duty), rest, phase, np.array(frequency_hz)),
        contact=equal_contacts(4, stiffness, mu),
        weight_n=MASS_KG * standard_gravity,
        low_pass=low_pass,
        outline_B=box(BODY_LENGTH_M, BODY_WIDTH_M),
        hips_B=np.column_stack([HIP_X_M * ahead, HIP_Y_M * left]),
    )
