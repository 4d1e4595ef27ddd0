"""The study of runs that were read: one for ``gap diagnose``, ``gap next`` and ``gap apply``."""

from collections.abc import Callable

from gap.diagnosis.comparison.commissioning import baseline_errors, commissioned_study
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause, Simulator
from gap.residuals.predictions import PredictsElsewhere
from robot.gap_report.kept_baseline import REUSED, baseline_of
from robot.gap_report.trials import Runs


def study_of(
    runs: Runs,
    simulator: Simulator,
    standing: tuple[Cause, ...] | None = None,
    elsewhere: PredictsElsewhere | None = None,
    *,
    own: bool = False,
    fresh: bool = False,
    notice: Callable[[str], None] = lambda _: None,
) -> Study:
    """Return the study of runs, with their baseline model errors in every prediction.

    Args:
        runs: Trials and references, and which of them judge.
        simulator: Of their machine.
        standing: Baseline model errors that an answer of the same runs says; None takes those kept from an
            earlier diagnosis with the same references, or finds them.
        elsewhere: Where predictions are made; None uses this process.
        own: Whether the simulator is more than runs and program say: then nothing is kept.
        fresh: Find them again, and keep them.
        notice: Gets a note where they were kept from before.

    Raises:
        GapError: The trials cannot be compared with the simulator.
    """

    def find(study: Study) -> tuple[Cause, ...]:
        causes, kept = baseline_of(study, "" if own else runs.kind.name, fresh=fresh)
        if kept:
            notice(REUSED)
        return baseline_errors(study) if causes is None else causes

    return commissioned_study(
        runs.trials, simulator, runs.references, elsewhere, runs.hold_out, standing, find
    )
