"""Whether a cause's size in the trials is beyond how that size differs between healthy runs.

Friction, springs and loads of a machine differ a little from day to day, alike through all of a run;
blocks of a run cannot show that, only runs can. So the fitted cause is fitted again, by its amplitude
alone, to each run: 1 in the trials if it is right, about 0 in references, each predicted by the others.
The two are compared by an F test over runs, two-sided and with one degree of freedom a parameter, because
the trials chose the direction. Scatter is pooled over the joints at which the effect could act
(``gap.search.scatter``), and with a small probability the joint is taken to be like no other. A cause that
has no other joints is steadied by how much all other causes scatter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.constants import JOINT_SHOWS
from gap.interfaces import Cause, Effect, Parameter, places_for
from gap.residuals.chances import harmonic_mean
from gap.residuals.evidence import Evidence
from gap.residuals.same_day import days_of
from gap.search.candidates import step_of
from gap.search.fit import Fitted
from gap.search.gait_by_gait import gait_by_gait
from gap.search.scatter import NOTHING_USUAL, Usual, UsualScatter, healthy_scatter
from gap.search.sizes import SEEN, Sizes, ahead_of, sizes_of
from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """Trials that are fitted to, and those that are held out; None where none is.

    A cause that was fitted to some is found in the others, too, by as much, if it is there.
    """

    fitted: Evidence
    held: Evidence | None = None


def chance_healthy(
    trials: Trials, healthy: Evidence, fitted: Fitted, added: Cause, usual: UsualScatter
) -> float:
    """Return the chance of so large a cause in a healthy machine, for this one candidate.

    Args:
        trials: Those that are fitted to, and those that are held out.
        healthy: References, whitened by what others predict.
        fitted: All causes, ``added`` among them.
        added: The cause.
        usual: How much causes scatter between references.
    """
    seen = sizes_in_trials(trials, fitted, added)
    if not len(seen):
        return 1.0  # it changes nothing where something is compared
    simulator = trials.fitted.simulator
    effect = next(one for one in simulator.effects if one.name == added.effect)
    single = len(added.joints) == 1
    places = [(place,) for place in places_for(effect, simulator)] if single else [added.joints]
    order = [added.joints, *(place for place in places if place != added.joints)]
    sizes = sizes_in_references(healthy, [replace(added, joints=place) for place in order])
    (known, noise), *elsewhere = sizes
    others = [values for values, own in elsewhere if _shows_there(own, noise)]
    others += sizes_across(healthy, added, effect)
    expected = usual.of(single).times(float(noise.mean()) if len(noise) else 1.0)
    return chance_of(seen, known, others, len(added.values), expected)


def _shows_there(own: FloatArray, here: FloatArray) -> bool:
    """Whether a cause shows at another joint, by its variances by noise there and here, (R,) each.

    A zero of the encoder of a vertical axis, which carries no weight, or what is much for a wrist, at a
    shoulder: sizes there are noise.
    """
    return len(own) > 0 and len(here) > 0 and float(here.mean() / own.mean()) > JOINT_SHOWS


def chance_of(
    seen: Sizes,
    known: Sizes,
    others: Sequence[Sizes],
    parameters: int,
    usual: Usual = NOTHING_USUAL,
) -> float:
    """Return the chance of the mean of sizes seen, if they were as those that are known.

    By two tests, of runs of all gaits together and gait by gait.

    Args:
        seen: Sizes in M trials.
        known: In N references; 0 is expected where there are none.
        others: In references at each of the other joints at which the effect could act, and along the
            other directions of its numbers.
        parameters: Of the cause; none counts as one.
        usual: How much sizes of other causes scatter, in units of these sizes.
    """
    ahead, runs = ahead_of(seen, known, usual.together.gaits_differ)
    together, directions = 1.0, max(parameters, 1)
    if ahead > 0.0:
        scatter = healthy_scatter([seen, known], others, usual.together)
        together = scatter.chance(ahead**2 / runs, directions)
    each = gait_by_gait(seen, known, others, usual.in_gaits)
    if each is None:
        return together
    apart = 1.0
    if each.ahead > 0.0:
        apart = each.scatter.chance(each.square, directions + each.gaits - 1)
    return harmonic_mean(together, apart)


def sizes_in_trials(trials: Trials, fitted: Fitted, added: Cause) -> Sizes:
    """Size of one of the fitted causes in each run that shows it, 1 where it is as fitted to all."""
    rest = tuple(one for one in fitted.causes if one is not added)
    compared = [(trials.fitted, fitted.residual)]
    if trials.held is not None:
        compared.append((trials.held, trials.held.residuals([fitted.causes])[0]))
    pulls, energies = [], []
    for evidence, left in compared:
        without = evidence.residuals([rest])[0] if rest else evidence.base
        pull, energy = _pulls(evidence, without, without - left, evidence.weights(left))
        pulls.append(pull)
        energies.append(energy)
    parts = [part for evidence, _ in compared for part in evidence.parts]
    gaits = tuple(part.gait for part in parts)
    sizes = sizes_of(np.concatenate(pulls), np.concatenate(energies), gaits, days_of(parts))
    return sizes.taken(range(len(gaits)))


def sizes_in_references(
    healthy: Evidence, causes: Sequence[Cause]
) -> list[tuple[Sizes, FloatArray]]:
    """Return for each cause by itself its size in each of R references, and the variance by noise, (R,)."""
    base = healthy.base
    changed = healthy.residuals([(one,) for one in causes])
    return [amplitudes(healthy, base, base - one, weights_of_runs(healthy, one)) for one in changed]


def weights_of_runs(healthy: Evidence, changed: FloatArray) -> FloatArray:
    """Weights by what a cause leaves of each reference, or by what there is without it, if that is less.

    Trials are weighed by what the cause leaves of them. It counts what it cannot explain for little, and
    is then large; a reference that it helps as much shows it as large only if it is weighed alike.
    """
    gained = (healthy.base_score - healthy.score(changed)).sum(axis=1)
    parts = healthy.block_part
    helped = np.bincount(parts, gained, len(healthy.parts)) > 0.0
    on = helped[parts][healthy.block_of_frame][:, None]
    return np.where(on, healthy.weights(changed), healthy.base_weights)


def sizes_across(healthy: Evidence, added: Cause, effect: Effect) -> list[Sizes]:
    """Return the sizes in references of changes across a cause of several numbers.

    A run's scatter shows along all of them. Each has the energy of the cause itself, and none of its shape.
    """
    if len(added.values) < 2 or any(p.located for p in effect.parameters):
        return []
    one_by_one = [
        replace(added, values=tuple(_moved(p, v) if k == i else p.neutral
                for k, (p, v) in enumerate(zip(effect.parameters, added.values, strict=True))))
        for i in range(len(added.values))
    ]  # fmt: skip
    base = healthy.base
    changed = healthy.residuals([(added,), *((one,) for one in one_by_one)])
    weights = weights_of_runs(healthy, changed[0])
    whole, *parts = (base - one for one in changed)
    rows = np.array([(part * np.sqrt(weights)).ravel() for part in parts])
    goal = (whole * np.sqrt(weights)).ravel()
    gram = rows @ rows.T
    if not np.all(np.diag(gram) > SEEN * float(goal @ goal)):
        return []
    mix = np.linalg.lstsq(gram, rows @ goal, rcond=None)[0]
    return [
        amplitudes(healthy, base, np.einsum("p,pfc->fc", across, np.array(parts)), weights)[0]
        for across in across_of(gram, mix)
    ]


def _moved(parameter: Parameter, value: float) -> float:
    """A fitted value; one that is near neutral is moved by a spread, within its bounds."""
    if abs(value - parameter.neutral) > 0.2 * parameter.spread:
        return value
    return parameter.neutral + step_of(parameter, parameter.neutral, 1.0)


def across_of(gram: FloatArray, direction: FloatArray) -> FloatArray:
    """Return D - 1 directions that are orthogonal to one of D in a metric, and as long, (D - 1, D)."""
    size = len(gram)
    ridge = 1e-9 * max(float(np.trace(gram)), 1e-30)
    root = np.linalg.cholesky(gram + ridge * np.eye(size))
    along = root.T @ direction
    length = float(np.linalg.norm(along))
    if length <= 0.0:
        return np.zeros((0, size))
    basis = np.linalg.qr(np.column_stack([along / length, np.eye(size)]))[0][:, 1:size]
    return np.asarray(length * np.linalg.solve(root.T, basis).T)


def amplitudes(
    evidence: Evidence, residual: FloatArray, change: FloatArray, weights: FloatArray
) -> tuple[Sizes, FloatArray]:
    """Fit a change to each of R runs by its size alone: sizes, and their variances by noise, (R,).

    Runs in which the change cannot be seen are left out.
    """
    pull, energy = _pulls(evidence, residual, change, weights)
    gaits = tuple(part.gait for part in evidence.parts)
    sizes = sizes_of(pull, energy, gaits, days_of(evidence.parts))
    seen = np.isfinite(sizes.values)
    return sizes.taken(range(len(gaits))), 1.0 / energy[seen]


def _pulls(
    evidence: Evidence, residual: FloatArray, change: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the pull of a residual on a change in each of R runs, and its energy, (R,)."""
    weighted = change * weights
    along = evidence.per_block(weighted * residual).sum(axis=1)
    power = evidence.per_block(weighted * change).sum(axis=1)
    runs = range(len(evidence.parts))
    pull = np.array([along[evidence.block_part == run].sum() for run in runs])
    return pull, np.array([power[evidence.block_part == run].sum() for run in runs])
