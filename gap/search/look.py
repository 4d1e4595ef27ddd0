"""One more cause: the best candidate that is new, beside what is known of healthy runs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from gap.constants import (
    FIRST_NATS,
    GAIN_SHARE,
    HIDDEN_SHARE,
    NEAR_BEST,
    OPEN_LEVEL,
    REST_SHARE,
    SECOND_NATS,
    SURELY_USUAL,
)
from gap.residuals.at_once import each_of
from gap.residuals.chances import clearer
from gap.residuals.energies import chance_of_energies
from gap.residuals.evidence import Evidence
from gap.search.beside_days import chance_beside_days, chance_beside_others
from gap.search.candidates import Family, families_of, too_small
from gap.search.contained import at_one_joint, containing
from gap.search.edges import limits_as_they_act, with_seen_edges
from gap.search.fit import Fitted
from gap.search.newest import newest, newest_left
from gap.search.novelty import Trials, chance_healthy
from gap.search.options import (
    CAUSE_LEVEL,
    Option,
    as_they_act,
    ends_on_bound,
    energy_share_of,
    fit_option,
    nats_beyond,
    share_of,
    shortlist,
    usual_score,
    worth,
)
from gap.search.screen import Gain, Signatures, gains
from gap.search.steps import Known, Search, Selection, Step
from model.values.arrays import FloatArray

BESIDE = 4  # candidates at single joints that are fitted beside walked ones of the whole machine
NEWEST = 4  # candidates that are fitted because they are new to first order, whatever they gain
# Of a first and of a second list: share of the best's first-order gain and nats that candidates must have.
LISTS = ((NEAR_BEST, FIRST_NATS), (0.0, SECOND_NATS))


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Looks for causes that are new beside what is known of healthy runs, if anything is."""

    evidence: Evidence
    known: Known | None
    search: Search

    @property
    def healthy(self) -> Evidence | None:
        """References; None for too few."""
        return self.known.runs if self.known else None

    def chance(self, option: Option) -> float:
        """Return its chance in a healthy machine, among all candidates; 0 without references."""
        if self.known is None:
            return 0.0
        one = self._chance_of_one(option, self.known)
        hunts = option.added.hunts
        if hunts and one < OPEN_LEVEL:  # which of all candidates it is, was seen before any fit
            return _both(one, hunts.chance)
        chance = self._among_all(one, option, self.known)
        if len(option.fitted.causes) > 1 and not hunts:
            beside = self._beside_others(one, option, self.known)
            chance = min(chance, beside) if beside < CAUSE_LEVEL else chance
        vibration = option.added.vibration
        if vibration is None or not option.added.effect.shaking or vibration.nats <= 0.0:
            return chance
        return min(chance, _both(chance, vibration.chance))

    def _among_all(self, one: float, option: Option, known: Known) -> float:
        return known.search.among_all(min(1.0, option.added.forms * one), option.added.family)

    def _beside_others(self, alone: float, option: Option, known: Known) -> float:
        """Chance of one more cause among all, beside what differs from day to day as well."""
        beside = chance_beside_others(
            self.evidence, known.search, option.added, option.cause, option.fitted, alone
        )
        return self._among_all(clearer(alone, beside), option, known)

    def _chance_of_one(self, option: Option, known: Known) -> float:
        """Chance of this one candidate, by itself and, if it is the only cause, beside days."""
        added, search = option.cause, known.search
        trials = Trials(self.evidence, known.held)
        alone = chance_healthy(trials, known.runs, option.fitted, added, search.alone.usual)
        if len(option.fitted.causes) > 1:
            return alone
        beside = chance_beside_days(
            self.evidence, search, option.added, added.values,
            self.evidence.base - option.fitted.residual,
        )  # fmt: skip
        return clearer(alone, beside)

    def level(self, fitted: Fitted) -> float:
        """Return the chance below which the next cause is named.

        Where a cause is named already, or what is left has more energy than healthy runs have, there is a
        gap, and the question is which causes it has; one must then only stand out from what healthy runs
        show as well.
        """
        if self.known is None:
            return 1.0
        if fitted.causes:
            return OPEN_LEVEL
        left = chance_of_energies(self.evidence, fitted.residual, self.known.each)
        return OPEN_LEVEL if left.shows_a_gap else CAUSE_LEVEL

    def least_nats(self, unseen: FloatArray) -> float:
        """Return what a cause has to gain where there are no references, of what is left in each block."""
        return self.search.least_gain * float(unseen.sum())

    def one_more(self, selection: Selection, signatures: Signatures) -> Step | None:
        """Return the best next cause, with its p-value (1: not to be taken) and its alternatives.

        With references, what differs most between days may be all of the first list; so there are more.
        Where none is to be taken, it is the one that is nearest to it.
        """
        forms = self._forms(selection, signatures)
        ranked = [best for best, *_ in forms.values()]
        options: list[Option] = []
        usual: list[tuple[Option, float]] = []
        open_ones: list[tuple[Option, float]] = []
        least_p, level = 1.0, self.level(selection.fitted)
        for listed in self._lists(ranked, selection.fitted):
            own = [forms[gain.signature.candidate.family] for gain in listed]
            find = partial(self._best_form, selection)
            made = each_of(own, find, self.evidence.predictor.at_once)
            fresh = sorted(with_seen_edges(self.evidence, made), key=rank)
            options += fresh
            for one in fresh:
                if not worth(one.over, len(one.added.effect.parameters), len(one.unseen)):
                    continue
                if too_small(one.cause, one.added.effect, self.search.least_size):
                    continue
                p = self.chance(one)
                if p < level and self._closes_enough(one, selection):
                    # what gains as much as the first cause is an alternative to it, however sure
                    if p < CAUSE_LEVEL or self.healthy is None or not selection.steps:
                        return self._taken(one, p, options, usual, selection)
                    open_ones.append((one, p))  # behind others a surer one may come
                    continue
                if self.healthy is None:
                    if one.added.hunts:  # it was looked at before the others
                        continue
                    return Step(one, (), 1.0)
                usual.append((one, p))  # healthy runs show it as well: no rival of what is new
                least_p = min(least_p, max(p, level))
        if open_ones:
            sure, p = min(open_ones, key=lambda own: own[1])
            return self._taken(sure, p, options, usual, selection)
        if usual:
            return Step(min(usual, key=lambda own: own[1])[0], (), least_p)
        return Step(min(options, key=rank), (), least_p) if options else None

    def _taken(
        self,
        one: Option,
        p: float,
        options: Sequence[Option],
        usual: Sequence[tuple[Option, float]],
        selection: Selection,
    ) -> Step:
        """Return what is taken, with its p-value and its alternatives, best first."""
        one, p = self.off_bound(one, p, options)
        best = containing(self.evidence, one, usual)
        ordered = sorted(options, key=rank)
        wider: list[Option] = []
        if self.known is not None:
            best, p = at_one_joint(self.evidence, best, p, ordered, self.chance, selection.unseen)
            joints = set(best.added.joints)
            wider = [other for other in ordered if joints & set(other.added.effect.each)]
        # what healthy runs show as well is no alternative to it, nor what every joint lacks beside it
        none = [best, *(other for other, _ in usual), *wider]
        rivals = tuple(
            other
            for other in ordered
            if other not in none and not best.added.hunts and not other.added.hunts
        )
        return Step(best, rivals, p, tuple(other.added.family for other in wider))

    def _forms(self, selection: Selection, signatures: Signatures) -> dict[Family, list[Gain]]:
        """Return the forms of each cause that may be next, the best form of each first."""
        taken = families_of(selection.fitted.causes, self.evidence.effects)
        taken |= {family for step in selection.steps for family in step.wider}
        residual = selection.fitted.residual
        least = self.least_nats(selection.unseen)
        ranked = gains(signatures, residual, self.evidence.weights(residual))
        listed = [
            gain
            for gain in limits_as_they_act(self.evidence, residual, signatures, ranked)
            if gain.signature.candidate.family not in taken
            and self._may_gain(gain, signatures, least)
        ]
        if self.search.walk:
            whole = [one for one in listed if not _at_a_joint(one)]
            walked = as_they_act(self.evidence, selection.fitted, whole)
            listed = [*(one.gain for one in walked), *filter(_at_a_joint, listed)]
        forms: dict[Family, list[Gain]] = {}
        for gain in listed:
            forms.setdefault(gain.signature.candidate.family, []).append(gain)
        return forms

    def _may_gain(self, gain: Gain, signatures: Signatures, nats: float) -> bool:
        """Whether a candidate may gain so much; a law that hardly changes the prediction may not."""
        one = gain.signature
        if one.candidate.effect.parameters or one.offset < 0:
            return True
        change = signatures.matrix[one.offset].reshape(self.evidence.base.shape)
        return self.evidence.most_gained(change) >= nats

    def _lists(self, ranked: list[Gain], standing: Fitted) -> Iterator[list[Gain]]:
        """Yield what is to be fitted, best first; with references the next best, then the newest.

        What hunts is before all others. Beside other causes, what healthy runs surely show as well to first
        order is not fitted.
        """
        hunting = [gain for gain in ranked if gain.signature.candidate.hunts]
        if hunting:
            ranked = [gain for gain in ranked if gain not in hunting]
            yield hunting
        by_itself: Mapping[Family, float] = {}
        if standing.causes:
            by_itself = self._newest_of(standing)
            ranked = [
                gain
                for gain in ranked
                if by_itself.get(gain.signature.candidate.family, 0.0) < SURELY_USUAL
            ]
        for near, least in LISTS if self.healthy is not None else LISTS[:1]:
            if self.search.walk:  # what is gained to first order is no measure for what was walked
                whole = [gain for gain in ranked if not _at_a_joint(gain)]
                at_joints = [gain for gain in ranked if _at_a_joint(gain)]
                listed = shortlist(whole, self.search.shortlist, near, least)
                most = BESIDE if whole else self.search.shortlist
                listed += shortlist(at_joints, most, near, least)
            else:
                listed = shortlist(ranked, self.search.shortlist, near, least)
            ranked = [gain for gain in ranked if gain not in listed]
            yield listed
        if self.known is None:
            return
        by_itself = by_itself or self._newest_of(standing)
        among_all = self.known.search.among_all
        new = [
            (chance, gain)
            for gain in ranked
            if (family := gain.signature.candidate.family) in by_itself
            and (chance := among_all(by_itself[family], family)) < OPEN_LEVEL
        ]
        yield [gain for _, gain in sorted(new, key=lambda one: one[0])[:NEWEST]]

    def _newest_of(self, standing: Fitted) -> dict[Family, float]:
        """Chance of each cause by itself in healthy runs, to first order; empty without them."""
        if self.known is None:
            return {}
        search = self.known.search
        if standing.causes:
            return newest_left(search, self.evidence, standing.residual)
        return newest(search)

    def _best_form(self, selection: Selection, forms: Sequence[Gain]) -> Option:
        """Return the best of the forms of a cause, which are listed with the best to first order first.

        One that to first order is far behind is not fitted.
        """
        best, *others = forms
        near = [best, *(one for one in others if one.nats >= NEAR_BEST * best.nats)]
        return min((self._fitted(selection, one) for one in near), key=rank)

    def _fitted(self, selection: Selection, gain: Gain) -> Option:
        added = gain.signature.candidate
        standing = selection.fitted
        start = (*standing.causes, added.cause(gain.values))
        # another law changes the slopes of all others
        near = standing if added.effect.parameters else None
        return fit_option(self.evidence, added, start, selection.unseen, self.search.rounds, near)

    def _closes_enough(self, one: Option, selection: Selection) -> bool:
        if self.healthy is None:
            least = self.least_nats(selection.unseen)
            share = share_of(self.evidence, one, selection.fitted, 0.0)
            return one.over.nats >= least and share >= self.search.least_share
        if not selection.steps:
            return True
        usual = usual_score(self.evidence, self.healthy)
        share = share_of(self.evidence, one, selection.fitted, usual)
        energy = energy_share_of(self.evidence, one, selection.fitted, self.healthy)
        return max(share, energy) >= REST_SHARE

    def off_bound(self, best: Option, p: float, options: Sequence[Option]) -> tuple[Option, float]:
        """Prefer to one fitted to its bound another that is no farther behind than the misfit hides."""
        if self.healthy is None or not ends_on_bound(best):
            return best, p
        left = nats_beyond(self.evidence, best.unseen, self.healthy)
        for other in sorted(options, key=lambda o: -o.over.nats):
            near = best.over.nats - other.over.nats < HIDDEN_SHARE * left
            if other is best or not near or ends_on_bound(other):
                continue
            other_p = self.chance(other)
            if other_p < CAUSE_LEVEL:
                return other, other_p
        return best, p


def _at_a_joint(gain: Gain) -> bool:
    """Whether a candidate is at one joint."""
    return len(gain.signature.candidate.joints) == 1


def _both(one: float, other: float) -> float:
    """Chance of two independent tests in one, by Fisher."""
    both = max(one * other, 1e-300)
    return both * (1.0 - math.log(both))


def rank(option: Option) -> tuple[float, object]:
    """Order of options: a parameter more must be worth a nat, and a place a share of what there is.

    Else a patch below all feet is better than a level by the little that a law is off where feet come down.
    """
    parameters, nats = option.added.effect.parameters, option.over.nats
    places = sum(one.located for one in parameters)
    return len(parameters) + places * GAIN_SHARE * max(nats, 0.0) - nats, option.added.key
