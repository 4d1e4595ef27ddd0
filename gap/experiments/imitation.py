"""The size at which a rival looks most like causes that were found, in the runs that were made."""

from collections.abc import Callable, Sequence

import numpy as np

from gap.interfaces import Cause, Drive, Simulator, reach_of
from gap.residuals.floor import Floor
from gap.search.candidates import FINE_STEP, Candidate, starts_of, step_of
from model.values.arrays import FloatArray
from record.trial.trial import Trial

STEPS = 4
WORTH = 0.999


def imitate(
    simulator: Simulator,
    trials: Sequence[Trial],
    causes: tuple[Cause, ...],
    of: int,
    rival: Candidate,
    floor: Floor,
) -> tuple[Cause, ...]:
    """Put a rival in the place of one cause, at the size that predicts the same runs best.

    Args:
        simulator: The simulator.
        trials: The runs.
        causes: What was found.
        of: Number of the cause to be replaced.
        rival: Effect and place that take its place.
        floor: Noise under ``Drive.COMMAND``.
    """
    sigma = np.fmax(floor.sigma * np.sqrt(floor.dependence), 1e-12)
    noise = [sigma / np.fmax(np.sqrt(simulator.observe(one).weight), 1e-12) for one in trials]

    def told(values: Sequence[float]) -> FloatArray:
        own = (*causes[:of], rival.cause(values), *causes[of + 1 :])
        return _rows(simulator, trials, own, noise)

    goal = _rows(simulator, trials, causes, noise)
    parameters = rival.effect.parameters
    base = told(rival.neutral)
    silent = []
    for i, p in enumerate(parameters):
        moved = list(rival.neutral)
        moved[i] += step_of(p, moved[i], 1.0)
        silent.append(bool(np.allclose(told(moved), base, atol=1e-6)))
    reach = reach_of([simulator.observe(one) for one in trials])
    starts = starts_of(rival.effect, silent, reach) if parameters else [()]
    found = [_descend(told, goal, rival, start) for start in starts]
    best = min(found, key=lambda one: one[0])
    return (*causes[:of], rival.cause(best[1]), *causes[of + 1 :])


def _rows(
    simulator: Simulator,
    trials: Sequence[Trial],
    causes: tuple[Cause, ...],
    noise: Sequence[FloatArray],
) -> FloatArray:
    rows = [
        np.nan_to_num(simulator.predict(one, causes, Drive.COMMAND) / own).ravel()
        for one, own in zip(trials, noise, strict=True)
    ]
    return np.concatenate(rows)


def _descend(
    told: Callable[[Sequence[float]], FloatArray],
    goal: FloatArray,
    rival: Candidate,
    start: Sequence[float],
) -> tuple[float, tuple[float, ...]]:
    """Gauss-Newton within bounds; return what is left and the values."""
    parameters = rival.effect.parameters
    values: FloatArray = np.array(start, dtype=np.float64)
    spread = np.array([p.spread for p in parameters])
    low = np.array([p.lower for p in parameters])
    high = np.array([p.upper for p in parameters])
    left = goal - told(values.tolist())
    energy = float(left @ left)
    for _ in range(STEPS if len(parameters) else 0):
        slopes = []
        for i, p in enumerate(parameters):
            by = step_of(p, float(values[i]), FINE_STEP)
            moved = values.copy()
            moved[i] += by
            slopes.append((told(moved.tolist()) - (goal - left)) * (p.spread / by))
        rows = np.array(slopes)
        gram = rows @ rows.T + np.eye(len(rows))
        step = np.linalg.solve(gram, rows @ left) * spread
        better = False
        for share in (1.0, 0.3):
            trial = np.clip(values + share * step, low, high)
            now = goal - told(trial.tolist())
            if float(now @ now) < WORTH * energy:
                values, left, energy, better = trial, now, float(now @ now), True
                break
        if not better:
            break
    return energy, tuple(float(v) for v in values)
