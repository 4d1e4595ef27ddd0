"""Causes against held-out runs: one that makes them worse is not named.

They are judged end to end, from commands alone. A cause with which held-out runs are clearly predicted
better where each stage is fed what was measured stays all the same (``gap.diagnosis.held_out.held_stage``).
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from gap.constants import (
    CLEAR_ERRORS,
    FALSE_ALARMS,
    HELD_OUT_ADDS,
    HELD_OUT_MOST,
    HELD_OUT_SIZEABLE,
    HELD_OUT_STAGE,
    LEAST_SIZE,
    SIZEABLE,
)
from gap.diagnosis.alternatives.probability import HALF, clear_of_nothing
from gap.diagnosis.comparison.gap_evidence import GapEvidence
from gap.diagnosis.comparison.how_far import HowFar, how_far
from gap.diagnosis.held_out.held_stage import agrees, helps_its_stage, share_of_stage
from gap.residuals.energies import chance_of_energies
from gap.residuals.evidence import Evidence
from gap.search.candidates import Family, families_of, size_of
from gap.search.options import CAUSE_LEVEL
from gap.search.replacement import fitted_for, in_its_place, left_out
from gap.search.standard_errors import standard_errors
from gap.search.steps import Selection

RIVALS = 2  # of a cause, that are tried in its place


def drop_worse(
    comparison: GapEvidence, selection: Selection, seed: int
) -> tuple[Selection, HowFar]:
    """Drop the causes without which held-out runs are clearly predicted better, the worst first.

    Where no references say how runs scatter, so are causes that together predict them worse than none (a
    alternative that fits as well is tried in their place), and one that adds next to nothing to the others.
    Returns the causes that are left, fitted again, and how far the gap shrinks with them. Where one was
    dropped, held-out runs have had a say in which causes are named, not in their sizes.
    """
    far = how_far(comparison.held, selection.fitted.causes, seed)
    alone = comparison.healthy is None
    helpful: set[Family] = set()
    while selection.steps:
        if alone and (any(far.worse) or _left(far) > far.before):
            selection, far = _better(comparison, selection, far, seed)
            continue
        at = (
            _idle(comparison, selection, far, helpful)
            if alone
            else _worst(comparison, selection, far)
        )
        if at is None:
            break
        selection = left_out(comparison.evidence, selection, {at})
        far = how_far(comparison.held, selection.fitted.causes, seed)
    return selection, far


def drop_unclear(
    comparison: GapEvidence, selection: Selection, far: HowFar, seed: int
) -> tuple[Selection, HowFar]:
    """Drop causes that are named with others and whose size is not clear of nothing, the least clear first.

    What a large cause leaves, because the simulator is not exactly the machine, looks like others. Some of
    them are new and help held-out runs, but are so few of their standard errors in size that, of so many
    effects, one is by chance. Where one also adds next to nothing to the others, it is enough that this is
    as likely as not, and where one alone says that there is a gap, too: healthy machines show as much. Only
    references tell how much sizes scatter, so without them only what is surely as good as nothing is
    dropped beside others.
    """
    evidence, alone = comparison.evidence, comparison.healthy is None
    while len(selection.steps) > int(alone):
        errors = standard_errors(evidence, comparison.healthy, selection.fitted)
        clear = clear_of_nothing(selection, evidence.effects, errors)
        if len(selection.steps) == 1:
            if clear[0] < HALF and not _energies_show_a_gap(comparison):
                selection = _as_usual(evidence, selection, 1.0 - clear[0])
                far = how_far(comparison.held, selection.fitted.causes, seed)
            break
        idle = set() if alone else adds_little(far)
        unclear = [
            at for at, one in enumerate(clear) if one < (HALF if at in idle else FALSE_ALARMS)
        ]
        if not unclear:
            break
        selection = left_out(evidence, selection, {min(unclear, key=clear.__getitem__)})
        far = how_far(comparison.held, selection.fitted.causes, seed)
    return selection, far


def _energies_show_a_gap(comparison: GapEvidence) -> bool:
    """Whether trials have more energy than healthy runs, whatever the causes."""
    evidence = comparison.evidence
    return chance_of_energies(evidence, evidence.base, comparison.runs).shows_a_gap


def _as_usual(evidence: Evidence, selection: Selection, chance: float) -> Selection:
    """Return the selection without its only cause, which healthy machines show with such a chance."""
    nothing = left_out(evidence, selection, {0})
    return replace(nothing, p=max(selection.p, chance), nearest=selection.steps[0].chosen)


def _worst(comparison: GapEvidence, selection: Selection, far: HowFar) -> int | None:
    """Number of the cause without which held-out runs are predicted better by most.

    Where there are others, one is in doubt as soon as it adds next to nothing to them: a large cause that
    is not exactly of the effect's form leaves a residual, in which chance finds others.
    """
    idle = adds_little(far)
    doubted = {i for i, worse in enumerate(far.worse) if worse} | idle
    # of what surely vibrates predictions show the mean alone, which may add next to nothing
    judged = {i for i in doubted if far.worse[i] or not selection.steps[i].chosen.added.vibrates}
    order = sorted(judged, key=lambda i: (far.last[i], i))
    # beside others a cause is new at a higher level, which is too high for one that adds nothing to them
    unsure = {i for i in idle if selection.steps[i].p >= CAUSE_LEVEL}
    causes = selection.fitted.causes
    return next(
        (i for i in order if i in unsure or not helps_its_stage(comparison, causes, i)), None
    )


def adds_little(far: HowFar) -> set[int]:
    """Numbers of the causes that add next to nothing to the others on held-out runs; none of one alone.

    Nor one that changes nothing there, such as a limit that is not reached: these runs cannot judge it.
    """
    several = len(far.last) > 1
    return {
        at
        for at, last in enumerate(far.last)
        if several and last < HELD_OUT_ADDS and far.changes(at)
    }


def _sizes(comparison: GapEvidence, selection: Selection) -> list[float]:
    effects = comparison.evidence.effects
    return [size_of(one, effects[one.effect]) for one in selection.fitted.causes]


def _idle(
    comparison: GapEvidence, selection: Selection, far: HowFar, helpful: set[Family]
) -> int | None:
    """Number of the cause that adds least to the others on held-out runs, if that is next to nothing.

    Beside a cause that explains nearly all of the gap (a servo that lags), others can add next to nothing
    to the whole and be right all the same: those that help their stage stay, large ones sooner. A
    small one helps its stage where it is only what a wrong law looks like, and an effect with numbers for
    each joint too easily; these are judged by the whole. What has helped beside others stays when these
    are dropped (it is added to ``helpful``): with fewer next to it, it may seem to help less.
    """

    def stays(at: int) -> bool:
        if selection.steps[at].chosen.added.effect.each or sizes[at] < LEAST_SIZE:
            return False  # judged by the whole
        causes = selection.fitted.causes
        least: float = HELD_OUT_SIZEABLE if sizes[at] >= SIZEABLE else HELD_OUT_STAGE
        if not causes[at].values:
            least = 0.0  # a law is there or not: it has no size that a misfit could choose
        elif sizes[at] >= SIZEABLE and share_of_stage(comparison, causes, at) >= HELD_OUT_MOST:
            least = 0.0  # little of its stage shows it, and shows little else
        return agrees(comparison, causes, at, least)

    sizes = _sizes(comparison, selection)
    families = [step.chosen.added.family for step in selection.steps]
    order = sorted(adds_little(far), key=lambda at: (far.last[at], at))
    idle = [at for at in order if families[at] not in helpful and not stays(at)]
    helpful |= {families[at] for at in order if at not in idle}
    return next(iter(idle), None)


def _better(
    comparison: GapEvidence, selection: Selection, far: HowFar, seed: int
) -> tuple[Selection, HowFar]:
    """Return the best of those with one cause less, or another in its place: two may be worse together."""
    others = [
        (one, how_far(comparison.held, one.fitted.causes, seed))
        for one in _changed(comparison, selection)
    ]
    fewer = [pair for pair in others if len(pair[0].steps) < len(selection.steps)]
    replaced = [pair for pair in others if pair not in fewer and _left(pair[1]) < _left(far)]
    return min((*fewer, *replaced), key=lambda pair: _left(pair[1]))


def _left(far: HowFar) -> float:
    """What the causes leave; without end where the simulation with them broke down."""
    return math.inf if math.isnan(far.after) else far.after


def _changed(comparison: GapEvidence, selection: Selection) -> Iterator[Selection]:
    """Yield the selection without each of its causes, and with an alternative that fits as well."""
    for at, step in enumerate(selection.steps):
        yield left_out(comparison.evidence, selection, {at})
        taken = families_of(selection.fitted.causes, comparison.evidence.effects)
        for rival in step.rivals[:RIVALS]:
            if rival.added.family in taken:
                continue
            option = fitted_for(comparison.evidence, selection, at, rival)
            if -option.over.nats < CLEAR_ERRORS * option.over.error:
                yield in_its_place(selection, at, option)
