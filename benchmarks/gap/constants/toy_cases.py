"""A tiny machine in nine realities, of which it is known what was wrong.

Sizes of causes reach from what hardly shows to what is plain, so that some answers hang on the constants:
cases that are right whatever these are would tell nothing.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.gap.constants.cases import KnownCase, drawn, truths_of
from gap.check.cases import CONTROL, OUTSIDE, PAIR, REMOVED, SINGLE
from gap.interfaces import Cause, Drive, check_causes
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import BUMP, EFFECTS, JOINTS, SPEED_GAIN, Toy, toy_trial

FORCEFUL = ("press", "move")  # stages whose effects act through forces
CATALOGUE = (
    *(replace(one, by_forces=one.stage in FORCEFUL) for one in (*EFFECTS, BUMP)),
    SPEED_GAIN,
)
LIFTED_N = 0.3  # a foot with less force is in the air


class FallingToy(Toy):
    """The tiny machine; it falls, and has no answer, where a foot is in the air."""

    stages = ("drive", "press", "move", "sensing")

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        check_causes(causes, self)
        out = super().predict(trial, causes, drive)
        out[(out[:, 3:6] < LIFTED_N).any(axis=1), 6] = np.nan
        return out


@dataclass(frozen=True, slots=True)
class Reality:
    """How the machine differs from its simulator even when healthy.

    Attributes:
        wander: How much each joint's stiffness differs from day to day.
        uneven: How much more it does at the first joint.
        strange: Size of a square wave in the forces that no effect is, in every run [N].
        healthy: Effects that every run has.
        references: How many healthy runs there are.
        elsewhere: Whether these are at other gaits and frequencies than the trials.
        forces: Whether forces are measured.
    """

    name: str
    wander: float = 0.01
    uneven: float = 1.0
    strange: float = 0.0
    healthy: tuple[Cause, ...] = ()
    references: int = 6
    elsewhere: bool = False
    forces: bool = True


REALITIES = (
    Reality("alike"),
    Reality("restless", wander=0.04),
    Reality("uneven", wander=0.02, uneven=3.0),
    Reality("elsewhere", wander=0.02, strange=0.03, elsewhere=True),
    Reality("laws", healthy=(
        Cause("delay", (), (0.02,)), Cause("square_law", (), ()), Cause("speed_gain", (), (1.02,)),
    )),
    Reality("few references", wander=0.02, references=3),
    Reality("no references", wander=0.002, references=0),
    Reality("no references, strange", wander=0.01, strange=0.03, references=0),
    Reality("no forces", wander=0.02, forces=False),
)  # fmt: skip
KINDS = (SINGLE, SINGLE, PAIR, CONTROL, CONTROL)  # and one outside or removed, in turn
CONDITIONS = ((0.5, "walk"), (0.8, "walk"), (0.5, "trot"), (0.8, "trot"))
ELSEWHERE = ((0.35, "walk"), (0.65, "walk"), (0.4, "trot"))


def toy_cases() -> Iterator[KnownCase]:
    """Yield all cases, always the same."""
    for number, reality in enumerate(REALITIES):
        last = OUTSIDE if number % 2 else REMOVED
        for at, kind in enumerate((*KINDS, last)):
            yield _toy_case(reality, kind, 1000 * number + at)


def _toy_case(reality: Reality, kind: str, seed: int) -> KnownCase:
    rng = np.random.default_rng([11, seed])
    numbered = [one for one in CATALOGUE if one.parameters]
    count = {SINGLE: 1, PAIR: 2, REMOVED: 1}.get(kind, 0)
    picked = [numbered[i] for i in rng.choice(len(numbered), count, replace=False)]
    causes = [drawn(effect, JOINTS, kind, rng) for effect in picked]
    strange = reality.strange + (rng.uniform(0.02, 0.12) if kind == OUTSIDE else 0.0)
    catalogue = tuple(
        one for one in CATALOGUE if kind != REMOVED or one.name not in {c.effect for c in causes}
    )
    trials = [
        _measured(reality, causes, strange, hz, gait, 100 * seed + i)
        for i, (hz, gait) in enumerate(CONDITIONS)
    ]
    places = ELSEWHERE if reality.elsewhere else CONDITIONS
    references = [
        _measured(reality, [], reality.strange, *places[i % len(places)], 100 * seed + 50 + i)
        for i in range(reality.references)
    ]
    return KnownCase(
        f"{reality.name} {kind} {seed}", kind, truths_of(picked, causes),
        FallingToy(catalogue), tuple(trials), tuple(references),
    )  # fmt: skip


def _measured(
    reality: Reality, causes: Sequence[Cause], strange: float, hz: float, gait: str, seed: int
) -> Trial:
    own = reality.wander * math.sqrt(reality.uneven**2 - 1.0)
    loose = np.random.default_rng([12, seed]).standard_normal()
    uneven = Cause("stiffness", JOINTS[:1], (1.0 + own * loose,))
    trial = toy_trial(
        [*reality.healthy, *causes, uneven], hz, gait, seed=seed, strange=strange,
        wander=reality.wander,
    )  # fmt: skip
    return trial if reality.forces else replace(trial, force_n=np.full_like(trial.force_n, np.nan))
