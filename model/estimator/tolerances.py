"""Robots that differ from the file by its tolerances, walking along: how far their answers lie apart."""

from functools import cache
from typing import NamedTuple

import numpy as np

from model.compiled import compiled
from model.estimator.tolerance_kernel import OTHERS
from model.values.arrays import FloatArray, readonly
from model.values.estimate import Companions


class Apart(NamedTuple):
    """What the companions answered in a frame, minus what the file's robot did.

    Attributes:
        velocity_B: (M, 3).
        load_share: Their loads over the weight, minus those of the file's robot, (M, N).
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    load_share: FloatArray


@compiled
def robots_beside(legs: int) -> int:
    """How many companions a robot of N legs has, M."""
    return 2 * (legs + OTHERS)


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
