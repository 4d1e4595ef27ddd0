"""Robots that differ from the file by its tolerances, walking along: how far their answers lie apart."""

from functools import cache
from typing import NamedTuple

import numpy as np

from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import Record
from model.estimator.tolerance_kernel import OTHERS, tolerance_kernel
from model.values.arrays import FloatArray, readonly
from model.values.estimate import Companions
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


class Apart(NamedTuple):
    """What the companions answered in a frame, minus what the file's robot did.

    Attributes:
        velocity_B: (M, 3).
        load_share: Their loads over the weight, minus those of the file's robot, (M, N).
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    load_share: FloatArray


@cache
def design(legs: int) -> FloatArray:
    """Errors of each companion in standard deviations, (M, N + 4): one error each, up or down."""
    errors = legs + OTHERS
    return readonly(np.vstack([np.eye(errors), -np.eye(errors)]))


def at_start(legs: int) -> Companions:
    """Companions of a robot that has not moved yet."""
    robots = len(design(legs))
    return Companions(
        readonly(np.full((robots, 3), np.nan)),
        readonly(np.zeros((robots, legs), dtype=bool)),
        readonly(np.zeros((robots, 3))),
        readonly(np.zeros((3, 3))),
    )


def walk_along(
    before: Companions,
    mean: FloatArray,
    feet: FootMotion,
    contact: ContactParameters,
    model: Neighbourhood,
    settings: Record,
    dt_s: float,
) -> tuple[Companions, Apart]:
    """Let the companions take a tick's step.

    Args:
        before: Where they were.
        mean: State of the estimator before the step, (n,).
        feet: At the step's end.
        contact: Stiffness and friction of the robot file.
        model: The answer at the robot file.
        settings: Of ``record_of``.
        dt_s: Length of the step [s].
    """
    signs = design(len(contact.mu))
    robots, legs = len(signs), len(contact.mu)
    twist, resting, moved = before.twist.copy(), before.resting.copy(), before.apart.copy()
    velocity, share, covariance = np.empty((robots, 3)), np.empty((robots, legs)), np.empty((3, 3))
    tolerance_kernel(
        mean, np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, settings, model.rows[0],
        model.slip_B, model.sway_B, signs, dt_s,
        twist, resting, moved, velocity, share, covariance,
    )  # fmt: skip
    for mine in (twist, resting, moved, covariance):
        readonly(mine)
    return Companions(twist, resting, moved, covariance), Apart(velocity, share)
