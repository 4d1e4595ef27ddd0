"""One frame of the whole model: support, then traction (the paper's steps A and B).

Called once a tick. The compiled path answers in microseconds; without numba the numpy functions of
``model.support.search`` and ``model.traction.viscous`` do the same work, and the tests hold the two
together.
"""

import numpy as np

from model.compiled import COMPILED
from model.errors import ModelError
from model.parameters.robot import ContactParameters
from model.quasistatic import frame_kernel
from model.support.search import solve_support
from model.traction.viscous import solve_traction
from model.values.contact import ContactSolution, Support, Traction
from model.values.legs import FootMotion

TIPS_WORDS = "the centre of mass is not above the feet: the robot tips"
WORDS = (
    "",
    "a foot position, velocity, stiffness or the load is not a number",
    "there are no feet",
    TIPS_WORDS,
    "the search for the contact set did not end; report the pose",
    "fewer than two feet are loaded",
    "the loaded feet stand in one point: turning is not determined",
    "load and stiffness must be positive",
)


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    if COMPILED:
        frame_kernel.prepare()


def solve_frame(feet: FootMotion, contact: ContactParameters, weight_n: float) -> ContactSolution:
    """Predict loads, body velocity, slip and foot forces from the feet.

    Args:
        feet: Unloaded feet of one frame in the body frame, (N, 3) each.
        contact: Leg springs and friction.
        weight_n: Weight carried [N].

    Raises:
        ModelError: Shapes do not fit.
    """
    if not COMPILED:
        return solve_frame_reference(feet, contact, weight_n)
    position, velocity = feet.position_m, feet.velocity_m_s
    count = position.shape[0]
    if position.shape != (count, 3) or velocity.shape != (count, 3) or count == 0:
        raise ModelError(f"feet must be (N, 3), not {position.shape} and {velocity.shape}")
    if contact.stiffness.shape != (count,) or contact.anisotropy.shape != (count, 2):
        raise ModelError(f"the contact parameters are not those of {count} legs")
    numbers = np.empty(7 + 6 * count)
    loaded = np.empty(count, dtype=np.bool_)
    found, reason = frame_kernel.solve(
        position, velocity, contact.stiffness, contact.mu, contact.anisotropy, weight_n, numbers,
        loaded,
    )  # fmt: skip
    numbers.setflags(write=False)
    loaded.setflags(write=False)
    slope_x, slope_y, height = numbers[:3].tolist()
    words = WORDS[reason]
    support = Support(
        found >= 0,
        "" if found >= 0 else words,
        height,
        slope_x,
        slope_y,
        numbers[7 : 7 + count],
        loaded,
        max(found, 0),
    )
    traction = Traction(
        reason == 0,
        words if found >= 0 else f"no support: {words}",
        numbers[3:6],
        numbers[7 + count : 7 + 3 * count].reshape(count, 2),
        numbers[7 + 3 * count :].reshape(count, 3),
    )
    return ContactSolution(support, traction)


def solve_frame_reference(
    feet: FootMotion, contact: ContactParameters, weight_n: float
) -> ContactSolution:
    """The same in numpy: slower, plainer, and what the compiled path is tested against."""
    support = solve_support(feet.position_m, contact.stiffness, weight_n)
    traction = solve_traction(
        feet.position_m, feet.velocity_m_s, support, contact.mu, contact.anisotropy
    )
    return ContactSolution(support, traction)
