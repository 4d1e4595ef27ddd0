"""What the true causes with their true numbers would close: the most that a diagnosis can be asked for."""

from collections.abc import Sequence

from gap.diagnosis.diagnose import measure_floor
from gap.diagnosis.how_far import how_far
from gap.interfaces import Cause, Drive, Simulator
from gap.residuals.evidence import make_evidence
from gap.residuals.parts import split, whole_part
from gap.residuals.predictions import Predictor
from record.trial.trial import Trial


def shrink_of(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial],
    causes: tuple[Cause, ...],
    standing: tuple[Cause, ...] = (),
    seed: int = 0,
) -> float:
    """Return the share of the gap that given causes close on the trials that a diagnosis keeps back.

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
    everything = (*trials, *references)
    observations = [simulator.observe(one) for one in everything]
    predictor = Predictor(simulator, everything, None, standing)
    fitted, held = split(trials, observations[: len(trials)])
    healthy = [
        whole_part(i, one, observations[i]) for i, one in enumerate(everything) if i >= len(trials)
    ]
    floor, _ = measure_floor(predictor, healthy, fitted, Drive.COMMAND)
    evidence = make_evidence(predictor, held, Drive.COMMAND, floor)
    return how_far(evidence, simulator.channels, causes, seed).shrink
