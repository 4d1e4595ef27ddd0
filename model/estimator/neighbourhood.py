"""The model at one frame with its derivatives, by one compiled call over stepped parameters."""

from functools import cache
from typing import NamedTuple

import numpy as np

from model.estimator import frame_kernel as estimator_kernel
from model.estimator.frame_kernel import Answers, Law
from model.estimator.settings import EstimatorSettings
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

VELOCITY, POSE, FORCES = slice(0, 3), slice(3, 6), slice(6, None)  # of what is differentiated


class Neighbourhood(NamedTuple):
    """The model's answer for N feet and its derivatives.

    Attributes:
        velocity_B: With sway, (3,).
        pose: slope_x, slope_y, height, (3,).
        force_B: Horizontal force on each foot and its load, (N, 3) [N].
        slip_B: (N, 2) [m/s].
        sway_B: Velocity of the body origin as it tilts, (2,) [m/s].
        slopes: The first three, one behind the other, by log mu, by log K and by the feet's speeds along
            x, (3 N, 6 + 3 N). Speeds change the velocity alone.
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    pose: FloatArray
    force_B: FloatArray  # noqa: N815
    slip_B: FloatArray  # noqa: N815
    sway_B: FloatArray  # noqa: N815
    slopes: FloatArray

    @property
    def load_n(self) -> FloatArray:
        """Load of each foot, (N,) [N]."""
        return self.force_B[:, 2]

    @property
    def pose_by_stiffness(self) -> FloatArray:
        """Derivatives of the pose by log K, (3, N)."""
        legs = len(self.force_B)
        return self.slopes[legs : 2 * legs, POSE].T


@cache
def no_answer(legs: int) -> Neighbourhood:
    """All NaN, for N feet: what stands where the model has no answer."""
    space, plane = np.full(3, np.nan), np.full((legs, 2), np.nan)
    return Neighbourhood(
        velocity_B=space,
        pose=space,
        force_B=np.full((legs, 3), np.nan),
        slip_B=plane,
        sway_B=np.full(2, np.nan),
        slopes=np.full((3 * legs, 6 + 3 * legs), np.nan),
    )


def _blank(legs: int) -> Answers:
    """Room for the answers of N feet."""
    return Answers(
        rows=np.empty((1 + 3 * legs, 6 + 3 * legs)),
        slip=np.zeros((legs, 2)),
        sway=np.zeros(2),
    )


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    estimator_kernel.prepare(law_of(EstimatorSettings()), _blank(1))


def law_of(settings: EstimatorSettings) -> Law:
    """How the settings have a frame solved."""
    return Law(
        coulomb=settings.law is FrictionLaw.COULOMB,
        sway_step=settings.sway_step_s if settings.sway else 0.0,
        rest_speed=settings.rest_speed,
    )


def neighbourhood(
    mean: FloatArray, feet: FootMotion, contact: ContactParameters, weight_n: float, law: Law
) -> Neighbourhood | None:
    """Solve a frame and step each parameter and foot speed by a little; None where it has no answer.

    Args:
        mean: State, (n,): its parameters are factors of the next.
        feet: (N, 3) each, all finite.
        contact: Stiffness and friction of the robot file.
        weight_n: Weight carried [N].
        law: How, of ``law_of``.
    """
    legs = len(contact.mu)
    answers = _blank(legs)
    reason = estimator_kernel.neighbourhood_kernel(
        mean,
        np.ascontiguousarray(feet.position_m),
        np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness,
        contact.mu,
        contact.anisotropy,
        weight_n,
        law,
        answers,
    )
    if reason != 0:
        return None
    rows, slip, sway = answers
    return Neighbourhood(
        velocity_B=rows[0, VELOCITY],
        pose=rows[0, POSE],
        force_B=rows[0, FORCES].reshape(legs, 3),
        slip_B=slip,
        sway_B=sway,
        slopes=rows[1:],
    )
