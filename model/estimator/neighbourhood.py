"""The model at one frame with its derivatives, by one compiled call over stepped parameters."""

from functools import cache
from typing import NamedTuple

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.estimator.frame_kernel import neighbourhood_kernel
from model.estimator.settings import Record
from model.values.arrays import FloatArray, readonly
from model.values.estimate import AddedByEffects
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


class Neighbourhood(NamedTuple):
    """The model's answer for N feet and its derivatives.

    Attributes:
        rows: Of the frame: velocity with sway, slope_x, slope_y, height, each foot's force; below it their
            derivatives by log mu, by log K and by the feet's speeds along x, (1 + 3 N, 6 + 3 N). Speeds
            change the velocity alone.
        slip_B: (N, 2) [m/s].
        sway_B: Velocity of the body origin as it tilts, (2,) [m/s].
    """

    rows: FloatArray
    slip_B: FloatArray  # noqa: N815 - frame suffix
    sway_B: FloatArray  # noqa: N815

    @property
    def velocity_B(self) -> FloatArray:  # noqa: N802
        """With sway, (3,)."""
        return self.rows[0, :3]

    @property
    def pose(self) -> FloatArray:
        """slope_x, slope_y, height, (3,)."""
        return self.rows[0, 3:6]

    @property
    def load_n(self) -> FloatArray:
        """Load of each foot, (N,) [N]."""
        return self.rows[0, 8::3]

    @property
    def force_n(self) -> FloatArray:
        """Force on each foot, (N, 3) [N]."""
        return self.rows[0, 6:].reshape(-1, 3)

    @property
    def pose_by_stiffness(self) -> FloatArray:
        """Derivatives of the pose by log K, (3, N)."""
        legs = len(self.slip_B)
        return self.rows[1 + legs : 1 + 2 * legs, 3:6].T


@cache
def no_answer(legs: int) -> Neighbourhood:
    """All NaN, for N feet: the value where the model has no answer."""
    shapes = (1 + 3 * legs, 6 + 3 * legs), (legs, 2), (2,)
    return Neighbourhood(*(readonly(np.full(shape, np.nan)) for shape in shapes))


def neighbourhood(
    mean: FloatArray, feet: FootMotion, contact: ContactParameters, settings: Record
) -> Neighbourhood | None:
    """Solve a frame and step each parameter and foot speed by a little; None where it has no answer.

    Args:
        mean: State, (n,): its parameters are factors of the next.
        feet: (N, 3) each, all finite.
        contact: Stiffness and friction of the robot file.
        settings: Of ``record_of``.
    """
    legs = len(contact.mu)
    answer = Neighbourhood(np.empty((1 + 3 * legs, 6 + 3 * legs)), np.empty((legs, 2)), np.empty(2))
    reason = neighbourhood_kernel(
        mean, np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, settings, *answer,
    )  # fmt: skip
    return answer if reason == 0 else None


def with_effects(model: Neighbourhood | None, added: AddedByEffects | None) -> Neighbourhood | None:
    """The answer with what effects add to it."""
    if model is not None and added is not None:
        add_effects(model.rows, added.velocity_B, added.load_n)
    return model


@in_place
@compiled
def add_effects(rows: FloatArray, velocity: FloatArray, load_n: FloatArray) -> None:
    """Add to rows of ``Neighbourhood``, in place, what effects add: (3,) and (N,)."""
    for i in range(3):
        rows[0, i] += velocity[i]
    for k in range(load_n.size):
        load = rows[0, 8 + 3 * k] + load_n[k]
        rows[0, 8 + 3 * k] = load if load > 0.0 or load != load else 0.0


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(add_effects, *out(2), *given(1, 1))
