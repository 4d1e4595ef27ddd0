"""Robots that differ from the file by its tolerances, walking along: how far their answers lie apart."""

from functools import cache
from math import cos, sin
from typing import NamedTuple

import numpy as np

from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import Record
from model.estimator.tolerance_kernel import OTHERS, tolerance_kernel
from model.values.arrays import FloatArray, readonly
from model.values.estimate import VELOCITY, YAW, Companions, paired_covariance
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


class Apart(NamedTuple):
    """What the companions answered in a frame, minus what the file's robot did.

    Attributes:
        velocity_B: (M, 3).
        load_share: Their loads over the weight, (M, N).
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    load_share: FloatArray

    @property
    def velocity_covariance(self) -> FloatArray:
        """(3, 3)."""
        return paired_covariance(self.velocity_B)

    @property
    def load_variance(self) -> FloatArray:
        """Of the load's share of each foot, (N,)."""
        return paired_covariance(self.load_share).diagonal()


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
    twist, resting = before.twist.copy(), before.resting.copy()
    velocity, loads = np.empty((robots, 3)), np.empty((robots, legs))
    tolerance_kernel(
        mean, np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, settings, model.rows[0],
        signs, twist, resting, velocity, loads,
    )  # fmt: skip
    moved = before.apart.copy()
    c, s = cos(mean[YAW]), sin(mean[YAW])
    vx, vy = mean[VELOCITY][:2].tolist()
    turned = moved[:, 2]
    moved[:, 0] += dt_s * (c * velocity[:, 0] - s * velocity[:, 1] - turned * (s * vx + c * vy))
    moved[:, 1] += dt_s * (s * velocity[:, 0] + c * velocity[:, 1] + turned * (c * vx - s * vy))
    moved[:, 2] += dt_s * velocity[:, 2]
    share = (loads - model.load_n) / settings[0]["weight_n"]
    return Companions(readonly(twist), readonly(resting), readonly(moved)), Apart(velocity, share)
