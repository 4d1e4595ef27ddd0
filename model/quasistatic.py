"""One frame of the whole model: support, then traction (the paper's steps A and B)."""

from model.params import ContactParameters
from model.signals import ContactSolution, FootMotion
from model.support import solve_support
from model.traction import solve_traction


def solve_frame(feet: FootMotion, contact: ContactParameters, weight_n: float) -> ContactSolution:
    """Predict loads, body velocity, slip and foot forces from the feet.

    Args:
        feet: Unloaded feet of one frame in the body frame, (N, 3) each.
        contact: Leg springs and friction.
        weight_n: Weight carried [N].
    """
    support = solve_support(feet.position_m, contact.stiffness, weight_n)
    traction = solve_traction(
        feet.position_m, feet.velocity_m_s, support, contact.mu, contact.anisotropy
    )
    return ContactSolution(support, traction)
