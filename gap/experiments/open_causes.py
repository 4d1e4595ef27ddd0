"""Causes with each alternative that is open, and the runs that discriminate between them.

Called at the end of a diagnosis and by ``bigant gap next``, which thereby propose the same runs: both
compare in the simulator with its baseline model errors.
"""

from collections.abc import Callable, Sequence

from gap.experiments.imitation import imitate
from gap.experiments.next_run import NextRun, next_runs
from gap.interfaces import Cause, Drive, Proposal
from gap.residuals.floor import Floor
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate
from record.trial.trial import Trial

MOST_TRIALS = 2  # in which an alternative is made to look like the cause


def open_sets(
    predictor: Predictor,
    trials: Sequence[Trial],
    floor: Floor,
    causes: tuple[Cause, ...],
    rivals: Sequence[tuple[int, Candidate]],
    drive: Drive,
    progress: Callable[[float], None] = lambda share: None,
) -> list[tuple[Cause, ...]]:
    """Return the causes, and for each alternative the causes with it instead of one.

    Args:
        predictor: The simulator, with the baseline model errors in it.
        trials: Measured runs.
        floor: Noise under the drive.
        causes: What was named beside the baseline model errors.
        rivals: Alternatives, each with the number of its cause.
        drive: What feeds the stages of the runs that judge.
        progress: Gets the share that is done.
    """
    standing, sets = predictor.standing, [causes]
    for number, (of, rival) in enumerate(rivals, 1):
        like = imitate(
            predictor.simulator, trials[:MOST_TRIALS], (*standing, *causes), len(standing) + of,
            rival, floor, drive,
        )  # fmt: skip
        sets.append(like[len(standing) :])
        progress(number / len(rivals))
    return sets


def discriminating_runs(
    predictor: Predictor,
    floor: Floor,
    sets: Sequence[tuple[Cause, ...]],
    proposals: Sequence[Proposal],
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[NextRun, ...]:
    """Rank proposals by how well they discriminate between sets of causes; see ``next_runs``."""
    whole = [(*predictor.standing, *one) for one in sets]
    return next_runs(proposals, predictor.simulator, whole, floor, progress)
