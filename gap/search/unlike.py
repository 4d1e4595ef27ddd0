"""One joint unlike the others, where no healthy run says what the simulator gets wrong at all of them.

A law of contact or a servo loop that the simulator has wrong, it has wrong at every joint: each joint then
asks for about the same change. A joint that asks for another stands out from the scatter of the others by
an F test, joints as each other's references: the energy of what it asks for beyond the mean of the others,
over theirs beyond the mean of each other. Only what is linear about its start can be compared so.
"""

from collections import defaultdict
from collections.abc import Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from gap.search.candidates import Candidate, Family
from gap.search.screen import Signature, Signatures
from model.values.arrays import FloatArray

FEWEST_OTHERS = 3  # joints at which the effect could act as well
LEAST_SCATTER = 1e-12  # of the energy at the joint itself


@dataclass(frozen=True, slots=True)
class UnlikeJoint:
    """An effect at one joint, and the chance of one so unlike the others where all are alike."""

    candidate: Candidate
    values: tuple[float, ...]
    chance: float


def unlike_joints(
    signatures: Signatures, residual: FloatArray, weights: FloatArray, taken: Set[Family]
) -> list[UnlikeJoint]:
    """Compare what each joint asks for with what the others do.

    Args:
        signatures: Of every candidate, about the causes that are named.
        residual: What these leave, whitened, (F, C).
        weights: Of each of its values, (F, C).
        taken: What is named already; it takes no part.

    Returns:
        Least chance first, each chance among all joints and effects that were compared.
    """
    weight = weights.astype(np.float32).ravel()
    pulled = signatures.matrix @ (residual.astype(np.float32).ravel() * weight)
    effects: dict[str, list[_Asked]] = defaultdict(list)
    for one in signatures.each:
        places = one.candidate.joints
        if len(places) == 1 and one.offset < 0 and one.rows:
            effects[one.candidate.effect.name].append(_asked(one, signatures, pulled, weight))
    compared = [
        one
        for own in effects.values()
        for one in _compared([asked for asked in own if len(asked.spreads) == _most(own)], taken)
    ]
    among = [replace(one, chance=_among(one.chance, len(compared))) for one in compared]
    return sorted(among, key=lambda one: (one.chance, one.candidate.key))


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """What a joint asks for, in spreads from neutral, (P,), and the energy of such changes, (P, P)."""

    candidate: Candidate
    values: tuple[float, ...]
    spreads: FloatArray
    energy: FloatArray


def _most(own: list[_Asked]) -> int:
    return max(len(one.spreads) for one in own)


def _asked(
    one: Signature, signatures: Signatures, pulled: FloatArray, weight: NDArray[np.float32]
) -> _Asked:
    rows = signatures.matrix[list(one.rows)]
    energy = ((rows * weight) @ rows.T).astype(np.float64)
    pull = pulled[list(one.rows)].astype(np.float64)
    step = np.asarray(np.linalg.solve(energy + np.eye(len(energy)), pull), np.float64)
    return _Asked(one.candidate, one.moved(step), step, energy)


def _compared(own: list[_Asked], taken: Set[Family]) -> list[UnlikeJoint]:
    out = []
    for at, one in enumerate(own):
        others = [
            other for i, other in enumerate(own) if i != at and other.candidate.family not in taken
        ]
        if len(others) < FEWEST_OTHERS or one.candidate.family in taken:
            continue
        mean = np.asarray(np.mean([other.spreads for other in others], axis=0), float)
        numbers, free = len(mean), len(mean) * (len(others) - 1)
        beyond = _energy(one, mean) / numbers / (1 + 1 / len(others))
        theirs = sum(_energy(other, mean) for other in others) / free
        f = beyond / max(theirs, LEAST_SCATTER * beyond, 1e-300)
        out.append(UnlikeJoint(one.candidate, one.values, float(special.fdtrc(numbers, free, f))))
    return out


def _among(chance: float, tests: int) -> float:
    """Chance that the least of so many is as small."""
    return -float(special.expm1(special.xlog1py(tests, -chance)))


def _energy(one: _Asked, mean: FloatArray) -> float:
    away = one.spreads - mean
    return float(away @ one.energy @ away)
