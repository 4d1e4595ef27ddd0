"""What causes leave at their own joints on runs that no fit has seen, beside what is left at the others.

A cause that only resembles the true one closes most of the gap and still leaves more at its own joint than
at any other, in the very channel in which it acts: a bias of a foot's force, where that foot clings to the
ground as it lifts off. What is left of a cause that is right is no more than at some other joint, but for a
share of what it changes: no effect of a machine has exactly the form of the modelled one.

It may also make another signal of its joint worse: a leg that is shorter, where one yields by its play
under load and hangs lower in the air.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import MOST_LEFT
from model.values.arrays import BoolArray, FloatArray

FEWEST_OTHERS = 2  # joints with the same channel, from which there is something to compare with


@dataclass(frozen=True, slots=True, eq=False)
class HeldOutEnergies:
    """Energies over expectation of C channels on held-out runs, without causes and with all of them.

    Attributes:
        names: Of the channels.
        joints: Where each is; empty for one of the whole machine.
        before: (C,).
        after: (C,).
        signals: Which of them a cause may not make worse, (C,): neither what lasts nor what feet trap.
    """

    names: Sequence[str]
    joints: Sequence[str]
    before: FloatArray
    after: FloatArray
    signals: BoolArray


def left_at_joint(
    energies: HeldOutEnergies, joint: str, causes: Collection[str], differs: float
) -> float:
    """Return how much more is left at a joint than at any other, where its cause acts most.

    Args:
        energies: On held-out runs.
        joint: Where the cause is.
        causes: All joints with causes, which nothing is compared with.
        differs: Share of its change by which such an effect of a machine differs from the modelled one.

    Returns:
        Logarithm of the energy over what is expected there, 0 to ``MOST_LEFT``; 0 where nothing can be
        compared.
    """
    before, after = energies.before, energies.after
    own = [i for i, at in enumerate(energies.joints) if at == joint and np.isfinite(after[i])]
    if not own:
        return 0.0
    most = max(own, key=lambda i: before[i] - after[i])
    others = _at_others(energies, energies.names[most], causes)
    if len(others) < FEWEST_OTHERS:
        return 0.0
    expected = max(*others, 1.0) + differs**2 * float(before[most])
    left = np.log(max(float(after[most]), 1e-12) / expected)
    return float(np.clip(left, 0.0, MOST_LEFT))


def made_worse(energies: HeldOutEnergies, joint: str, causes: Collection[str]) -> float:
    """Return by how much causes make a signal of a joint worse than it was, and than it is elsewhere.

    The arguments are those of ``left_at_joint``.

    Returns:
        Energy over expectation, 0 to ``MOST_LEFT``.
    """
    worst = 0.0
    for i, (name, at) in enumerate(zip(energies.names, energies.joints, strict=True)):
        if at == joint and energies.signals[i] and np.isfinite(energies.after[i]):
            usual = max(1.0, float(energies.before[i]), *_at_others(energies, name, causes))
            worst = max(worst, float(energies.after[i]) - usual)
    return min(worst, MOST_LEFT)


def _at_others(energies: HeldOutEnergies, name: str, causes: Collection[str]) -> list[float]:
    """Energies of a channel at joints without causes, with all causes."""
    return [
        float(after)
        for own, at, after in zip(energies.names, energies.joints, energies.after, strict=True)
        if own == name and at not in causes and np.isfinite(after)
    ]
