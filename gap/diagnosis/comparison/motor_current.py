"""What motors draw, against references: nothing predicts it, and a loop can hide all else of a cause.

A servo whose controller integrates pushes through friction, load or a bent part, and its shaft follows as
before. Only its current shows it. Where the simulator does not predict currents, the reader is told of the
difference, and no verdict uses it.
"""

from collections.abc import Sequence

import numpy as np

from gap.diagnosis.comparison.study import Study
from gap.residuals.floor import ENOUGH_REFERENCES
from model.values.arrays import FloatArray
from record.trial.trial import Trial

# All trials beyond all references, by this factor: fifty per cent is more than warm gears differ by.
CLEAR_RATIO = 1.5
LEAST_A = 0.05  # some counts of a servo's register (3.36 mA each in an MX-106)
CURRENT = "current"


def current_words(study: Study) -> str:
    """Return a sentence where currents are clearly not the references'; empty otherwise."""
    trials, references = study.trials, study.predictor.trials[len(study.trials) :]
    predicted = any(one.name.startswith(CURRENT) for one in study.simulator.channels)
    if predicted or not trials or len(references) < ENOUGH_REFERENCES:
        return ""
    seen, known = mean_currents(trials), mean_currents(references)
    joints = trials[0].header.joints
    more = seen.min(axis=0) > CLEAR_RATIO * known.max(axis=0) + LEAST_A
    less = CLEAR_RATIO * seen.max(axis=0) + LEAST_A < known.min(axis=0)
    by_joint = [
        f"{joint} {seen[:, at].mean():.2g} A ({known[:, at].mean():.2g} A)"
        for at, joint in enumerate(joints)
        if more[at] or less[at]
    ]
    if not by_joint:
        return ""
    return (
        f"motor currents are not those of the references: {', '.join(by_joint)} in the mean, references in "
        "brackets. Currents are not predicted, so no verdict knows of this: look for friction, load or a "
        "jam at these joints"
    )


def mean_currents(trials: Sequence[Trial]) -> FloatArray:
    """Return the mean size of each joint's current in each run, (R, J) [A]; NaN where not measured."""
    means = []
    for trial in trials:
        known = np.isfinite(trial.current_a)
        count = known.sum(axis=0)
        total = np.where(known, np.abs(trial.current_a), 0.0).sum(axis=0)
        means.append(np.where(count > 0, total / np.maximum(count, 1), np.nan))
    return np.array(means)
