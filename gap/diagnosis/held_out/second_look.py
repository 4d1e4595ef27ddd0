"""Without references, a second look for causes that are small beside what the simulator has wrong.

The first causes are then mostly what the simulator lacks on this machine, healthy or not: laws, and what
legs that were built by hand differ in. What is wrong with it comes after these. So the search goes on for
causes that gain as much of the whole score as a baseline model error must. A cause in one leg gains less,
and so does one at a place: these are named if they explain their part of what is left in their channels,
the one in a leg only where this is unlike the others. So are, last, one of the whole machine that is large
and explains a part of its channels, most of it in held-out runs; one in a leg, alike or not, that
explains most of its channels there; and either that is larger than machines are built with. Each must help
to predict held-out runs, each stage fed with what was measured.
"""

from collections.abc import Callable, Sequence, Set
from dataclasses import replace

from gap.constants import FALSE_ALARMS, LAW_GAIN, LEAST_SIZE, PLACE_SHARE, REST_SHARE
from gap.diagnosis.comparison.gap_evidence import GapEvidence
from gap.diagnosis.held_out.demand import AGAIN, BEYOND_BUILT, LARGE, MOST, Demand, may_meet, meets
from gap.diagnosis.held_out.held_stage import agrees
from gap.interfaces import Drive
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, Family, families_of, size_of
from gap.search.contained import containing
from gap.search.look import Look, rank
from gap.search.options import Option, as_they_act, fit_option, share_of, worth
from gap.search.replacement import left_out
from gap.search.screen import Gain, Signatures, gains, make_signatures
from gap.search.steps import Search, Selection, Step
from gap.search.unlike import unlike_joints

MOST_MORE = 8  # causes
FITTED = 3  # joints, or places, at each step
FITTED_BY_SHARE = 4  # candidates that may meet a demand, at each step
WALKED = 60  # candidates at single joints that are predicted at a few sizes, at each step
SMALLER = (1.0, 0.75, 0.5, 0.25)  # of its size, if it acted everywhere
AS_A_LAW = Search(least_gain=LAW_GAIN, least_size=LEAST_SIZE, walk=True)


def second_look(
    comparison: GapEvidence, selection: Selection, dropped: Set[Family] = frozenset()
) -> Selection:
    """Return the selection with the causes that stand out beside those that are named.

    Args:
        comparison: Trials against the simulator; with references there is no second look.
        selection: The causes so far.
        dropped: Causes that held-out runs spoke against. Where the search comes back to one of them it goes
            on with that one in the fit, so that what it hides is found, but does not name it. It is named
            again at a joint and at a place, as little of the whole is much of a joint; and if it is large
            and explains its part where each stage is fed what was measured.
    """
    if comparison.study.references or comparison.study.local is Drive.COMMAND:
        return selection  # nothing could be judged stage by stage
    evidence, first = comparison.evidence, selection
    signatures = make_signatures(
        evidence, comparison.candidates, selection.fitted.causes, lambda _: None
    )
    hidden: set[int] = set()  # numbers of causes that are not named
    for _ in range(MOST_MORE + len(dropped)):
        ranked = _gains(comparison, selection, signatures)
        part = _one_joint(comparison, selection, signatures, ranked) or _at_a_place(
            comparison, selection, ranked
        )
        law = None if part else _as_a_law(comparison, selection, signatures)
        step = (
            part
            or law
            or _in_its_channels(comparison, selection, ranked)
            or _most_of_a_joint(comparison, selection, ranked)
        )
        if step is None:
            break
        option, standing = step.chosen, selection.fitted
        steps = (*selection.steps, step)
        selection = replace(selection, fitted=option.fitted, unseen=option.unseen, steps=steps)
        if (
            law is not None
            and option.added.family in dropped
            and not meets(comparison, option, standing, AGAIN)
        ):
            hidden.add(len(steps) - 1)
        if len(steps) - len(hidden) == len(first.steps) + MOST_MORE:
            break
    if not hidden:
        return selection
    if len(selection.steps) - len(hidden) == len(first.steps):
        return first
    return left_out(evidence, selection, hidden)


def _one_joint(
    comparison: GapEvidence,
    selection: Selection,
    signatures: Signatures,
    ranked: Sequence[Gain],
) -> Step | None:
    """Return the cause at a joint that is unlike the others."""
    evidence, standing = comparison.evidence, selection.fitted
    taken = families_of(standing.causes, evidence.effects)
    compared = unlike_joints(
        signatures, standing.residual, evidence.weights(standing.residual), taken
    )
    unlike = [(one.candidate, one.values) for one in compared if one.chance < FALSE_ALARMS]
    step = _best(comparison, selection, unlike[:FITTED])
    return step and _at_its_joint(comparison, selection, ranked, step)


def _at_its_joint(
    comparison: GapEvidence, selection: Selection, ranked: Sequence[Gain], step: Step
) -> Step:
    """Return the best effect at a joint that is unlike the others.

    Only what is linear can be compared over joints; play, for one, cannot. But it may fit better there.
    """
    joints, family = step.chosen.added.joints, step.chosen.added.family
    other = _best_of(
        comparison, selection, ranked, lambda one: one.joints == joints and one.family != family
    )
    if other is None:
        return step
    first, second = sorted((step, other), key=lambda one: rank(one.chosen))
    rivals = {one.added.key: one for one in (*second.rivals, *first.rivals, second.chosen)}
    return Step(first.chosen, tuple(rivals.values()))


def _at_a_place(
    comparison: GapEvidence, selection: Selection, ranked: Sequence[Gain]
) -> Step | None:
    """Return the cause at a place of the world, which only what came there has met."""
    step = _best_of(comparison, selection, ranked, _located)
    return step if step is not None and _only_there(comparison.evidence, step.chosen) else None


def _only_there(evidence: Evidence, option: Option) -> bool:
    """Whether half of what an option gains is lost if it acts from where the machine began."""
    *others, last = option.fitted.causes
    effect = option.added.effect
    moved = []
    for share in SMALLER:
        values = [
            max(p.lower, evidence.reach_m[0]) if p.located  # the lower where the reach is unknown
            else p.neutral + share * (value - p.neutral)
            for p, value in zip(effect.parameters, last.values, strict=True)
        ]  # fmt: skip
        moved.append((*others, replace(last, values=tuple(values))))
    there, *elsewhere = evidence.nats([option.fitted.causes, *moved])
    return min(elsewhere) - there >= PLACE_SHARE * option.over.nats


def _best_of(
    comparison: GapEvidence,
    selection: Selection,
    ranked: Sequence[Gain],
    asked: Callable[[Candidate], bool],
) -> Step | None:
    """Return the best of the candidates that are asked for, the others fitted as alternatives.

    The few that gain most to first order are fitted.
    """
    wanted = [
        (candidate, one.values) for one in ranked if asked(candidate := one.signature.candidate)
    ]
    return _best(comparison, selection, wanted[:FITTED])


def _gains(comparison: GapEvidence, selection: Selection, signatures: Signatures) -> list[Gain]:
    """Return what candidates that are not named yet gain to first order, best first."""
    evidence, residual = comparison.evidence, selection.fitted.residual
    taken = families_of(selection.fitted.causes, evidence.effects)
    return [
        gain
        for gain in gains(signatures, residual, evidence.weights(residual))
        if gain.signature.candidate.family not in taken
    ]


def _located(one: Candidate) -> bool:
    """Whether a candidate acts at a place of the world."""
    return any(p.located for p in one.effect.parameters)


def _best(
    comparison: GapEvidence,
    selection: Selection,
    candidates: Sequence[tuple[Candidate, tuple[float, ...]]],
) -> Step | None:
    """Return the best that is large and clear and explains its part, the others as alternatives."""
    options = _fitted(comparison, selection, candidates)
    options.sort(key=lambda one: -one.over.nats)

    def explains(option: Option) -> bool:
        large = size_of(option.cause, option.added.effect) >= LEAST_SIZE
        return large and share_of(comparison.evidence, option, selection.fitted, 0.0) >= REST_SHARE

    return _first(comparison, options, explains)


def _fitted(
    comparison: GapEvidence,
    selection: Selection,
    candidates: Sequence[tuple[Candidate, tuple[float, ...]]],
) -> list[Option]:
    """Fit each candidate beside what is named."""
    evidence, standing = comparison.evidence, selection.fitted
    return [
        fit_option(
            evidence, one, (*standing.causes, one.cause(values)), selection.unseen, near=standing
        )
        for one, values in candidates
    ]


def _first(
    comparison: GapEvidence, options: Sequence[Option], explains: Callable[[Option], bool]
) -> Step | None:
    """Return the first that is clear, explains enough and helps held-out runs.

    Others at the same joint are its alternatives; at another joint they explain other channels.
    """
    for option in options:
        clear = worth(option.over, len(option.added.effect.parameters), len(option.unseen))
        if clear and explains(option) and _agrees(comparison, option):
            joints = option.added.joints
            others = (one for one in options if one is not option and one.added.joints == joints)
            return Step(option, tuple(others))
    return None


def _as_a_law(comparison: GapEvidence, selection: Selection, signatures: Signatures) -> Step | None:
    """Return the next cause of the ordinary search, if it gains as much as a baseline model error must."""
    look = Look(comparison.evidence, None, AS_A_LAW)
    taken = look.one_more(selection, signatures)
    if taken is None or taken.p >= look.level(selection.fitted):
        return None
    return taken if _agrees(comparison, taken.chosen) else None


def _in_its_channels(
    comparison: GapEvidence, selection: Selection, ranked: Sequence[Gain]
) -> Step | None:
    """Return a cause of the whole machine that gains little of the whole, and enough of its channels."""

    def asked(one: Candidate) -> bool:
        return len(one.joints) != 1 and not _located(one) and bool(one.effect.parameters)

    some = [one for one in ranked if asked(one.signature.candidate)]
    return _by_share(comparison, selection, some, (LARGE, BEYOND_BUILT))


def _most_of_a_joint(
    comparison: GapEvidence, selection: Selection, ranked: Sequence[Gain]
) -> Step | None:
    """Return a cause at one joint that explains most of what its channels show, or is very large.

    What is not linear, and what all joints ask for a little of, is not found unlike others.
    """

    def asked(one: Candidate) -> bool:
        return len(one.joints) == 1 and not _located(one)

    some = [one for one in ranked if asked(one.signature.candidate)]
    step = _by_share(comparison, selection, some[:WALKED], (MOST, BEYOND_BUILT))
    return step and _at_all_joints(comparison, selection, ranked, step)


def _at_all_joints(
    comparison: GapEvidence, selection: Selection, ranked: Sequence[Gain], step: Step
) -> Step:
    """Return the same effect at all joints, if it explains more and leaves little for the one joint.

    Servos that all give explain little of the whole, and each servo most of its own channel.
    """
    family = step.chosen.added.effect.family
    whole = [
        (candidate, one.values)
        for one in ranked
        if not (candidate := one.signature.candidate).joints and candidate.effect.family == family
    ]
    agreed = [
        (one, 0.0) for one in _fitted(comparison, selection, whole) if _agrees(comparison, one)
    ]
    agreed.sort(key=lambda one: rank(one[0]))
    chosen = containing(comparison.evidence, step.chosen, agreed)
    return step if chosen is step.chosen else Step(chosen, (step.chosen,))


def _by_share(
    comparison: GapEvidence,
    selection: Selection,
    some: Sequence[Gain],
    demands: Sequence[Demand],
) -> Step | None:
    """Return the best that meets one of the demands."""
    standing = selection.fitted
    walked = as_they_act(comparison.evidence, standing, some)
    may: dict[object, tuple[Candidate, tuple[float, ...]]] = {}
    for demand in demands:
        near = [one for one in walked if may_meet(one, demand)]
        near.sort(key=lambda one: (-one.share, one.gain.signature.candidate.key))
        for one in near[:FITTED_BY_SHARE]:
            candidate = one.gain.signature.candidate
            may.setdefault(candidate.key, (candidate, one.gain.values))
    options = _fitted(comparison, selection, list(may.values()))
    options.sort(key=rank)
    return _first(
        comparison,
        options,
        lambda one: any(meets(comparison, one, standing, demand) for demand in demands),
    )


def _agrees(comparison: GapEvidence, option: Option) -> bool:
    """Whether held-out runs speak for what an option adds, its last cause."""
    causes = option.fitted.causes
    return agrees(comparison, causes, len(causes) - 1)
