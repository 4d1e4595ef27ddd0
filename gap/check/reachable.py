"""What the true causes with their true numbers would close: the most that a diagnosis can reach."""

from collections.abc import Sequence

from gap.diagnosis.how_far import how_far
from gap.diagnosis.study import make_study
from gap.interfaces import Cause, Simulator
from record.trial.trial import Trial


def shrink_of(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial],
    causes: tuple[Cause, ...],
    standing: tuple[Cause, ...] = (),
    seed: int = 0,
) -> float:
    """Return the share of the gap that given causes close on the trials that a diagnosis holds out.

    Args:
        trials: Measured runs.
        simulator: The simulator under diagnosis.
        references: Runs of the same machine believed healthy.
        causes: The causes, with their numbers.
        standing: What the references show already; it stands before and after.
        seed: Of the resampling.

    Returns:
        The same figure as ``HowFar.shrink``; NaN if there is no gap to close.

    Raises:
        GapError: A cause does not fit the simulator.
    """
    study = make_study(trials, simulator, references).with_standing(standing)
    return how_far(study.held_evidence(), causes, seed).shrink
