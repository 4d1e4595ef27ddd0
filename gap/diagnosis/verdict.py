"""The verdict, the causes and their alternatives with all details, and what limits a diagnosis."""

from collections.abc import Iterator, Sequence

import numpy as np

from gap.constants import (
    CLEAR_EXCESS,
    EXCESS_ERRORS,
    FALSE_ALARMS,
    IN_DOUBT_SHARE,
    MOST_PART,
    NONE_LIKELY,
)
from gap.diagnosis.ambiguity import OpenRival
from gap.diagnosis.detection import Detection
from gap.diagnosis.findings import NamedCause, Value, Verdict
from gap.diagnosis.how_far import HowFar
from gap.diagnosis.motor_current import current_words
from gap.diagnosis.new_commands import none_repeats
from gap.diagnosis.probability import HALF
from gap.diagnosis.study import Study
from gap.diagnosis.trend import Trend
from gap.interfaces import Cause, Effect, place_words
from gap.residuals.evidence import Evidence
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.rounding import value_words
from gap.search.candidates import on_bound
from gap.search.options import Option
from gap.search.steps import Selection
from model.values.arrays import FloatArray

FEW_BLOCKS = 6
CLEARLY_LEFT = 1.0  # e-folds of energy
LITTLE = 0.25  # share of the gap on held-out runs that is little for causes that are named


def gap_exists(
    evidence: Evidence, detection: Detection | None, selection: Selection, hunts: bool = False
) -> bool:
    """Whether there is a gap: a cause that is new, or what no healthy machine shows without any cause.

    ``hunts`` is whether a joint hunts as in no reference.
    """
    if selection.steps or hunts:
        return True
    if detection is not None:
        return detection.below
    excess, count = evidence.excess(evidence.base), evidence.count.sum(axis=0)
    limit = np.fmax(CLEAR_EXCESS, 1.0 + EXCESS_ERRORS * np.sqrt(2.0 / np.fmax(count, 1.0)))
    return bool(np.any(excess > limit))


def verdict_of(
    exists: bool,
    named: Sequence[NamedCause],
    none: float,
    ambiguous: Sequence[OpenRival],
    *,
    helps: bool = True,
) -> Verdict:
    """Choose among the four; a cause on a bound of its values explains nothing.

    Nor do causes that do not help to predict held-out runs, or leave a joint that hunts (``helps`` is
    False).

    It is not ambiguous for causes that explain next to nothing: the rest is what the simulator lacks.
    """
    if not exists:
        return Verdict.NO_GAP
    on_bound = any(value.on_bound for one in named for value in one.values)
    if not named or none > NONE_LIKELY or on_bound or not helps:
        return Verdict.UNEXPLAINED
    doubted = {one.of for one in ambiguous}
    shares = np.array([one.shrink for one in named])  # NaN where runs are too few to tell
    theirs = shares[[(one.effect, one.joints) in doubted for one in named]].sum()
    small = not doubted or theirs <= IN_DOUBT_SHARE * shares.sum()
    return Verdict.EXPLAINED if small else Verdict.AMBIGUOUS


def named_causes(
    selection: Selection,
    probabilities: Sequence[float],
    far: HowFar,
    trends: Sequence[Trend],
    errors: FloatArray,
    clear: Sequence[float],
) -> tuple[NamedCause, ...]:
    """Return the causes with everything known of them, the one that closes most first.

    That is by held-out runs, or by those that were fitted to, where held-out runs do not show all causes.
    There is one probability, one trend and one ``clear_of_nothing`` a cause; the standard errors are in
    spreads, (P,).
    """
    causes, at = [], 0
    parts = _parts(far, len(selection.steps))
    for i, (cause, step) in enumerate(zip(selection.fitted.causes, selection.steps, strict=True)):
        effect = step.chosen.added.effect
        size = len(effect.parameters)
        judged = far.changes(i)
        causes.append(
            NamedCause(
                effect=effect.family,
                joints=cause.joints,
                stage=effect.stage,
                values=fitted_values(effect, cause, errors[at : at + size]),
                probability=probabilities[i],
                nats=step.chosen.over.nats,
                nats_error=step.chosen.over.error,
                shrink=parts[i] if judged else np.nan,
                alone=far.alone[i] if judged else np.nan,
                last=far.last[i] if judged else np.nan,
                physics=effect.physics,
                remedy=effect.remedy,
                form=effect.name,
                trend=trends[i],
                clear=clear[i],
                vibration=step.chosen.added.vibration,
                p=step.p,
            )
        )
        at += size
    if not all(map(far.changes, range(len(causes)))):
        return tuple(sorted(causes, key=lambda one: -one.nats))
    return tuple(sorted(causes, key=lambda one: -np.nan_to_num(one.shrink, nan=0.0)))


def _parts(far: HowFar, count: int) -> list[float]:
    """Each cause's part of what all close: the mean of first and last in, made to add up.

    All NaN where causes undo so much of each other that one would close more than the whole gap.
    """
    raw = far.each
    total = float(raw.sum())
    if not np.isfinite(far.shrink) or not total > 0.0:  # nor NaN
        return [np.nan] * count
    parts = raw * far.shrink / total
    if np.abs(parts).max() > MOST_PART:
        return [np.nan] * count
    return [float(part) for part in np.fmin(parts, 1.0)]


def fitted_values(effect: Effect, cause: Cause, errors: FloatArray) -> tuple[Value, ...]:
    """Return the values of a cause with their errors, (P,) in spreads, and which lie on a bound."""
    out = []
    for p, value, error in zip(effect.parameters, cause.values, errors, strict=True):
        ends = on_bound(p, value)
        out.append(Value(p.name, p.unit, value, float(error) * p.spread, p.neutral, ends))
    return tuple(out)


def resembling(left_there: float) -> Iterator[str]:
    """Return that a cause may only resemble the true one, where clearly more is left at its joint."""
    if left_there >= CLEARLY_LEFT:
        yield (
            f"on held-out runs a named cause leaves {np.exp(left_there / 2):.1f} times as much at its "
            "joint as is left at others (RMS): it may only resemble the true one; compare the curves of "
            "that joint"
        )


def warnings_of(
    study: Study,
    blocks: int,
    named: Sequence[NamedCause],
    far: HowFar,
    detection: Detection | None,
    selection: Selection,
) -> Iterator[str]:
    """Return what limits the diagnosis, one sentence each.

    ``blocks`` is how many there are to fit to, and ``selection`` has what was nearly a cause.
    """
    references, fitted = len(study.references), {part.trial for part in study.fitted}
    if not references:
        yield "without reference runs, permanent simulator errors cannot be separated from new faults"
    elif not study.calibrated:
        yield "fewer than 3 references: the false-alarm rate cannot be estimated"
    elif references < ENOUGH_REFERENCES:
        yield (
            "two references hardly show how much healthy runs differ: only what is clearly larger is "
            "new; without references the same trials get a first guess that names more"
        )
    elif not named and none_repeats(study.references):
        yield (
            "no two references were commanded alike: they tell how far gaits, frequencies and turns are "
            "apart, and not how well the machine repeats one, so small causes are hidden. Two of each "
            "show smaller ones"
        )
    if len(fitted) < 2 and not study.calibrated:
        yield "+- covers only within-run noise; run-to-run variation needs more runs"
    if fitted & {part.trial for part in study.held}:
        yield (
            "only one run per gait: the first two thirds were used for fitting, the last third for "
            "testing"
        )
    if study.exchange is not None:
        own, other = study.exchange.fitted + 1, study.exchange.held + 1
        yield (
            f"run {own} shows a gap that the runs to fit to do not show, so it is fitted to, and run "
            f"{other} is held out in its place"
        )
    for joint in study.hunting:
        yield (
            f"{joint.words}: look for play in its gears, or too high a gain of its loop. No simulator "
            "follows this frame by frame, so meanwhile its readings and its foot do not count"
        )
    if blocks < FEW_BLOCKS:
        yield f"only {blocks} blocks to fit to; record longer runs"
    if references and not {p.gait for p in study.fitted} <= {p.gait for p in study.references}:
        yield "a gait has no reference run: its baseline is uncertain"
    if study.references and any(far.worse):
        if far.end_to_end:
            yield (
                "end to end, from commands alone, held-out runs are predicted worse with a named cause; it "
                "is named because they are predicted better where each stage is fed with measurements"
            )
        else:
            yield (
                "held-out runs are predicted worse with a named cause in some of their channels; it is "
                "named because the channels that it acts on are predicted better"
            )
    if study.references and named and far.high < LITTLE:
        most = 100.0 * max(far.high, 0.0)
        yield (
            f"on held-out runs the named causes explain {most:.0f} % of the gap at the most: what is new "
            "may only be like them, or not alone; look at what remains"
        )
    if detection is not None:
        beside = "fitted beside what is named" if named else "fitted to these runs"
        for step in selection.refused:
            yield (
                f"{_sized(step.chosen)}, {beside}, is larger than in the references (chance in healthy "
                f"runs {step.p:.2g}), but held-out runs are predicted no better with it. So it is not "
                "named, and what it fits remains: record more runs"
            )
        if detection.by_energy and detection.in_cycles:
            yield (
                f"{_energy_words(detection)}, most in {detection.energy_in}: look for something loose, for "
                "knocks, wind or a connection that fails now and then"
            )
        if detection.nearly:
            yield from _nearly(detection, selection.nearest)
    if not named and (currents := current_words(study)):
        yield currents
    if np.isfinite(far.shrink) and (
        hidden := [place_words(one.effect, one.joints) for one in named if np.isnan(one.last)]
    ):
        yield (
            f"the runs held out for testing do not show {' and '.join(hidden)}, so they cannot judge it; "
            "record another run like the one that shows it"
        )
    for one in named:
        place = place_words(one.effect, one.joints)
        if one.clear < HALF:
            yield (
                f"{place}: its size is so few of its +- from nothing that, of so many effects, one has as "
                "much by chance"
            )
        if one.trend.surely(len(named)):
            size = 100.0 * one.trend.growth
            yield (
                f"{place} changes by {size:+.0f} % of its size in the course of a run, which no effect of "
                "the catalogue does: look for wear, heat, dust, a battery"
            )
        for value in one.values:
            if value.on_bound:
                yield f"{place}: {value.name} is on its bound: not an effect of this form"


def _energy_words(detection: Detection) -> str:
    """Say which energy is farthest ahead of references."""
    if detection.in_cycles:
        return "what is left differs from cycle to cycle by more than in references"
    return "what is left beyond the references' prediction"


def _nearly(detection: Detection, nearest: Option | None) -> Iterator[str]:
    """Say what is nearly a gap: nobody should take it for excluded."""
    if detection.nearest == "cause" and nearest is not None:
        what = _sized(nearest)
    elif detection.nearest == "energy":
        what = f"{_energy_words(detection)}, most in {detection.energy_in}"
    else:
        return
    yield (
        f"nearly a gap: {what}. {100.0 * detection.p:.2g} % of healthy sets of trials show as much, and "
        f"what less than {100.0 * FALSE_ALARMS:.0f} % show is a gap: record more trials or references"
    )


def _sized(option: Option) -> str:
    """Name a cause with its place and fitted size."""
    cause, effect = option.cause, option.added.effect
    sizes = ", ".join(
        f"{p.name} {value_words(value, 0.0, p.unit)}"
        for p, value in zip(effect.parameters, cause.values, strict=True)
    )
    return place_words(cause.effect, cause.joints) + (f" ({sizes})" if sizes else "")
