"""The model's answer for one frame: what the legs carry, how the feet slip."""

from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from model.values.quick import quick


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """Height, slopes and foot loads at which the leg springs carry the body.

    Attributes:
        converged: False when there is no equilibrium; ``reason`` says why and the numbers are NaN.
        reason: Empty when converged.
        height_m: Height of the body origin above the ground.
        slope_x: Slope along x (rotation about y, pitch; the paper's alpha_x).
        slope_y: Slope along y (rotation about x, roll; the paper's alpha_y).
        load_n: Ground's vertical force on each foot, (N,) [N], 0 for a foot in the air.
        contact: (N,) bool.
        switches: Contact changes taken by the search.
    """

    converged: bool
    reason: str
    height_m: float
    slope_x: float
    slope_y: float
    load_n: FloatArray
    contact: BoolArray
    switches: int


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Traction:
    """Planar balance of friction: body velocity, slip and forces.

    Attributes:
        valid: False when the balance has no unique answer; ``reason`` says why, numbers are NaN.
        reason: Empty when valid.
        velocity_B: Body velocity in body axes, (3,): vx [m/s], vy [m/s], yaw rate [rad/s].
        slip_B: Velocity of each foot over the ground in body axes, (N, 2) [m/s]; NaN in the air.
        force_B: Ground's force on each foot in body axes, (N, 3) [N]; 0 in the air.
    """

    valid: bool
    reason: str
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    slip_B: FloatArray  # noqa: N815
    force_B: FloatArray  # noqa: N815


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """The model's answer for one frame: support, then traction."""

    support: Support
    traction: Traction


def no_contact(legs: int, reason: str) -> ContactSolution:
    """Return what is known of ``legs`` feet where the model was not run, and why not."""
    nan = float("nan")
    loads, standing = np.full(legs, nan), np.zeros(legs, dtype=bool)
    support = Support(False, reason, nan, nan, nan, loads, standing, 0)
    traction = Traction(
        False, reason, np.full(3, nan), np.full((legs, 2), nan), np.full((legs, 3), nan)
    )
    return ContactSolution(support, traction)
