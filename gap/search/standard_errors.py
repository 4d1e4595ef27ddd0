"""How sure the fitted numbers are: by noise within runs, and by how much runs differ from each other.

Blocks of a run cannot show what differs from day to day alike through all of it (a spring that is warm, a
floor that is damp), so an error from noise alone is far too small. The size of each cause is therefore
found again in each run by itself, in references too, as ``gap.search.novelty`` does it; their scatter is
the error of one run. Of causes with several numbers the runs may agree on the size and not on the numbers,
so all of them are also found without each run in turn (the jackknife, Efron and Stein 1981,
DOI 10.1214/aos/1176345462). Runs may also agree because the simulator is wrong in the same way in all of
them: then kinds of channels (forces along x, feet along y) want different numbers, which the fit balances.
What each kind pulls at the numbers is the error of a sandwich with kinds as clusters (Liang and Zeger 1986,
DOI 10.1093/biomet/73.1.13). The largest of the four errors is taken.

References may all show a little of the cause, beyond what they predict of each other: a body has inertia,
and harmonics of the gait's phase hold little of what that does where legs change. So a part of the size in
the trials is the healthy machine's. How large a part is not known, so it is added (in squares).

None of them shows that the machine follows other laws than the simulator: runs agree on a number that is
off in all of them. By how much that happens was measured on virtual robots of other structure than the
simulator's; such a share of the cause's size is added (in squares). What feet grip in the mean while they
stick and slip faster than frames tells their law of friction only roughly; what is reported has that, too.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from gap.constants import FORCES_DIFFER, MEAN_DIFFERS, MODELS_DIFFER, PLACES_DIFFER
from gap.interfaces import Cause, Effect
from gap.residuals.evidence import Evidence
from gap.search.candidates import is_limit, only_a_limit
from gap.search.cross_validation import steps_without
from gap.search.fit import Fitted
from gap.search.novelty import Trials, sizes_in_references, sizes_in_trials
from gap.search.scatter import scatter
from model.values.arrays import FloatArray

SHOWN_SHARE = 1e-3  # of a number's energy, below which other runs do not show it


def standard_errors(evidence: Evidence, healthy: Evidence | None, fitted: Fitted) -> FloatArray:
    """Return the standard error of every parameter in spreads, (P,), in the order of ``fitted.away``.

    ``healthy`` are references, None where there are none or too few.
    """
    if not len(fitted.away):
        return np.zeros(0)
    weighted = fitted.slopes * evidence.weights(fitted.residual)
    gram = _products(weighted, fitted.slopes)
    within = _by_noise(evidence, fitted, gram)
    shares = [_shares(*_sizes_of_runs(evidence, healthy, fitted, cause)) for cause in fitted.causes]
    numbers = [len(cause.values) for cause in fitted.causes]
    between, usual = _from_nothing(evidence, fitted) * np.repeat(shares, numbers, axis=0).T
    # the scatter of runs has the noise in it already
    over_runs = np.fmax(np.fmax(within, between), _without_each_run(evidence, fitted))
    measured = np.fmax(over_runs, _between_channels(evidence, fitted, weighted, gram))
    return np.asarray(np.sqrt(measured**2 + usual**2 + _of_the_model(evidence, fitted) ** 2))


def with_rough_means(
    effects: Mapping[str, Effect], causes: Sequence[Cause], errors: FloatArray
) -> FloatArray:
    """Return standard errors of all parameters, (P,), for a report: what a mean tells of a law is little.

    How sure it is that there is such a cause is another question, and not answered by these.
    """
    rough = [float(bool(effects[one.effect].shaking)) for one in causes for _ in one.values]
    return np.asarray(np.hypot(errors, MEAN_DIFFERS * np.array(rough)))


def _from_nothing(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """How far numbers are from where nothing happens, in spreads, (P,), as what they change grows there.

    A limit changes nothing until it is reached: then it moves by as much as slopes need for all of it.
    """
    away, at = np.abs(fitted.away), 0
    for cause in fitted.causes:
        if only_a_limit(evidence.effects[cause.effect]):
            others = tuple(one for one in fitted.causes if one is not cause)
            change = evidence.residuals([others])[0] - fitted.residual
            slope = np.linalg.norm(fitted.slopes[at])
            away[at] = min(away[at], np.linalg.norm(change) / slope if slope > 0.0 else np.inf)
        at += len(cause.values)
    return away


def _of_the_model(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """How far numbers are off because the simulator's laws are not quite the machine's, in spreads."""
    errors, at = [], 0
    for cause in fitted.causes:
        effect = evidence.effects[cause.effect]
        away = fitted.away[at : at + len(cause.values)]
        at += len(cause.values)
        located = np.array([one.located for one in effect.parameters], dtype=bool)
        share = FORCES_DIFFER if effect.by_forces else MODELS_DIFFER
        size = np.abs(away) if effect.each else np.linalg.norm(away[~located])
        off = np.where(located, PLACES_DIFFER, share * size)
        for i, (p, value) in enumerate(zip(effect.parameters, cause.values, strict=True)):
            if is_limit(p):  # how far it is from where nothing reaches it says nothing
                off[i] = FORCES_DIFFER * value / p.spread
        errors.append(off)
    return np.concatenate(errors)


def _products(weighted: FloatArray, slopes: FloatArray) -> FloatArray:
    """Products of weighted slopes with slopes, (P, P)."""
    count = len(slopes)
    return np.asarray(weighted.reshape(count, -1) @ slopes.reshape(count, -1).T)


def _by_noise(evidence: Evidence, fitted: Fitted, gram: FloatArray) -> FloatArray:
    # in spreads; where misfit is left, it scatters the estimate too
    left = max(evidence.mean_excess(fitted.residual), 1.0)
    return np.asarray(np.sqrt(left * np.diag(np.linalg.inv(gram + np.eye(len(gram))))))


def _without_each_run(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """Jackknife over runs; 0 for one run.

    Without the only run that shows a number there is none, so that run is not left out for it.
    """
    run_of_frame = evidence.block_part[evidence.block_of_frame]
    runs, steps = steps_without(evidence, fitted, run_of_frame)
    energy = (fitted.slopes**2 * evidence.weights(fitted.residual)).sum(axis=2)
    each = np.array([energy[:, run_of_frame == run].sum(axis=1) for run in runs])
    steps = np.where(each.sum(axis=0) - each < SHOWN_SHARE * each.sum(axis=0), 0.0, steps)
    scatter = ((steps - steps.mean(axis=0)) ** 2).sum(axis=0)
    return np.asarray(np.sqrt((len(runs) - 1) / len(runs) * scatter))


def _between_channels(
    evidence: Evidence, fitted: Fitted, weighted: FloatArray, gram: FloatArray
) -> FloatArray:
    """Scatter of what kinds of channels pull at the numbers, in spreads; 0 where one kind was measured."""
    names = [one.name for one in evidence.simulator.channels]
    seen = evidence.count.sum(axis=0) > 0
    kinds = [name for name in dict.fromkeys(names) if any(seen[k] for k in _of(names, name))]
    if len(kinds) < 2:
        return np.zeros(len(fitted.away))
    # about where the data alone would have the numbers: what the prior pulls is no kind's
    pull = np.einsum("pfc,fc->p", weighted, fitted.residual)
    step = np.linalg.pinv(gram, hermitian=True) @ pull
    residual = fitted.residual - np.einsum("p,pfc->fc", step, fitted.slopes)
    pulls = np.einsum("pfc,fc->cp", weighted, residual)
    of_kinds = np.array([pulls[_of(names, name)].sum(axis=0) for name in kinds])
    moves = np.linalg.solve(gram + np.eye(len(gram)), of_kinds.T)
    return np.asarray(np.sqrt(len(kinds) / (len(kinds) - 1) * (moves**2).sum(axis=1)))


def _of(names: list[str], name: str) -> list[int]:
    """Numbers of the channels of a kind."""
    return [number for number, one in enumerate(names) if one == name]


def _sizes_of_runs(
    evidence: Evidence, healthy: Evidence | None, fitted: Fitted, cause: Cause
) -> tuple[FloatArray, FloatArray]:
    """Sizes of a cause in trials, (M,), and in references, (N,); none of these where there are too few."""
    trials = sizes_in_trials(Trials(evidence), fitted, cause).values
    if healthy is None:
        return trials, np.zeros(0)
    return trials, sizes_in_references(healthy, [cause])[0][0].values


def _shares(trials: FloatArray, references: FloatArray) -> tuple[float, float]:
    """Standard errors of a cause's size as shares of it: by runs that differ, and by what references show.

    None of what all references show to all of it may be in the trials' size: of a share that may be
    anything from 0 to 1 the mean square is a third. Both are 0 where there is only one run.
    """
    square, free = scatter([trials, references])
    if free < 1:
        return 0.0, 0.0
    variance = square / free
    between = np.sqrt(variance * sum(1.0 / len(one) for one in (trials, references) if len(one)))
    if not len(references):
        return float(between), 0.0
    beyond = max(float(references.mean() ** 2 - variance / len(references)), 0.0)
    return float(between), float(np.sqrt(beyond / 3.0))
