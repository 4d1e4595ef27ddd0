"""A robot as data: everything the model needs to predict its motion, and how to draw it."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray, readonly
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

RATE_HZ = 100.0  # frames a second of systems, as of the paper's recordings
FEWEST_FRAMES = 2
EVENNESS = 1e-6  # of the time step


@dataclass(frozen=True, slots=True, eq=False)
class System:
    """F frames of a robot with N feet, evenly spaced in time.

    Attributes:
        name: Short name.
        description: One line on what it is.
        time_s: (F,) [s].
        feet: Unloaded feet in the body frame, (F, N, 3) each [m], [m/s].
        contact: Leg springs and friction.
        weight_n: Weight carried [N].
        ground_m: Height of the ground under each foot, (F, N) [m]; None where it is level.
        anisotropy_B: w of each contact where it turns with a part of the body, (F, N, 2); it then
            stands in for ``contact.anisotropy``. None where w is constant in the body frame.
        low_pass: Coefficient of the filter that stands in for inertia (``model.motion.low_pass``), or None.
        outline_B: Rigid body seen from above, a polygon, (M, 2) [m]; None where the contacts, in
            order, are the body. For pictures only.
        hips_B: Where each leg meets the body seen from above, (N, 2) [m], or None. For pictures only.

    Raises:
        ModelError: Shapes do not fit, or the frames are not evenly spaced.
    """

    name: str
    description: str
    time_s: FloatArray
    feet: FootMotion
    contact: ContactParameters
    weight_n: float
    ground_m: FloatArray | None = None
    anisotropy_B: FloatArray | None = None  # noqa: N815 - frame suffix
    low_pass: float | None = None
    outline_B: FloatArray | None = None  # noqa: N815
    hips_B: FloatArray | None = None  # noqa: N815

    def __post_init__(self) -> None:
        position = self.feet.position_m
        if position.ndim != 3 or position.shape[2] != 3:
            raise ModelError(f"feet of a system must be (F, N, 3), not {position.shape}")
        frames, legs = position.shape[:2]
        wanted: tuple[tuple[str, FloatArray | None, tuple[int, ...]], ...] = (
            ("time_s", self.time_s, (frames,)),
            ("feet velocity", self.feet.velocity_m_s, (frames, legs, 3)),
            ("stiffness", self.contact.stiffness, (legs,)),
            ("mu", self.contact.mu, (legs,)),
            ("anisotropy", self.contact.anisotropy, (legs, 2)),
            ("ground_m", self.ground_m, (frames, legs)),
            ("anisotropy_B", self.anisotropy_B, (frames, legs, 2)),
            ("hips_B", self.hips_B, (legs, 2)),
        )
        for name, array, shape in wanted:
            if array is not None and array.shape != shape:
                raise ModelError(f"{self.name}: {name} must be {shape}, not {array.shape}")
        if frames < FEWEST_FRAMES:
            raise ModelError(f"{self.name}: a motion needs at least {FEWEST_FRAMES} frames")
        steps = np.diff(self.time_s)
        if not (steps > 0).all() or np.ptp(steps) > EVENNESS * steps[0]:
            raise ModelError(f"{self.name}: the frames must be evenly spaced in time")

    @property
    def frames(self) -> int:
        """Number of frames F."""
        return len(self.time_s)

    @property
    def legs(self) -> int:
        """Number of feet N."""
        return len(self.contact.mu)

    @property
    def step_s(self) -> float:
        """Time from frame to frame [s]."""
        return float(self.time_s[1] - self.time_s[0])


def even_times(duration_s: float, rate_hz: float = RATE_HZ) -> FloatArray:
    """Times of evenly spaced frames, the first at 0, (F,) [s].

    Raises:
        ModelError: Fewer than two frames fit.
    """
    if not (np.isfinite(duration_s) and duration_s > 0 and np.isfinite(rate_hz) and rate_hz > 0):
        raise ModelError(f"{duration_s:g} s at {rate_hz:g} Hz: both must be positive")
    count = round(duration_s * rate_hz)
    if count < FEWEST_FRAMES:
        raise ModelError(f"{duration_s:g} s at {rate_hz:g} Hz is too short for a motion")
    times: FloatArray = np.arange(count) / rate_hz
    return times


def equal_contacts(legs: int, stiffness: float, mu: float) -> ContactParameters:
    """Contact of N legs alike, stiffness in N/m, with isotropic friction."""
    return ContactParameters(
        stiffness=readonly(np.full(legs, float(stiffness))),
        mu=readonly(np.full(legs, float(mu))),
        anisotropy=readonly(np.zeros((legs, 2))),
    )


def box(length: float, width: float) -> FloatArray:
    """Corners of a body of this length and width about the origin, (4, 2) [m]."""
    corners: FloatArray = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length / 2, width / 2)
    return corners
