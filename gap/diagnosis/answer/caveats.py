"""What limits a diagnosis: one sentence for everything that a reader should know beside the answer."""

from collections.abc import Iterator, Sequence

import numpy as np

from gap.constants import FALSE_ALARMS
from gap.diagnosis.alternatives.probability import HALF
from gap.diagnosis.answer.named_cause import NamedCause
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.how_far import HowFar
from gap.diagnosis.comparison.motor_current import current_words
from gap.diagnosis.comparison.new_commands import none_repeats
from gap.diagnosis.comparison.study import Study
from gap.interfaces import place_words
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.residuals.same_day import SILENT_TRIALS, days_of
from gap.rounding import count_words, value_words
from gap.search.options import Option
from gap.search.steps import Selection

FEW_BLOCKS = 6
CLEARLY_LEFT = 1.0  # e-folds of energy
LITTLE = 0.25  # share of the gap on held-out runs that is little for causes that are named


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
    yield from _of_runs(study, blocks, named)
    if study.references:
        yield from _of_held_out_runs(named, far)
    if detection is not None:
        yield from _of_the_test(named, detection, selection)
    if not named and (currents := current_words(study)):
        yield currents
    yield from _of_unjudged(named, far)
    for one in named:
        yield from _of_a_cause(one, len(named))


def _of_runs(study: Study, blocks: int, named: Sequence[NamedCause]) -> Iterator[str]:
    """What trials and references do not show."""
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
    elif 0 < (days := len(set(days_of(study.references)))) < ENOUGH_REFERENCES:
        yield (
            f"the references are of {count_words(days, 'day')}, which hardly shows how much days "
            "differ: only what is far larger is new. Record some on another day; files that do not say "
            "their day count each run, and more is named then, also what only differs from day to day"
        )
    elif not named and none_repeats(study.references):
        yield (
            "no two references were commanded alike: they tell how far gaits, frequencies and turns are "
            "apart, and not how well the machine repeats one, so small causes are hidden. Two of each "
            "show smaller ones"
        )
    if any(part.day == SILENT_TRIALS for part in study.fitted):
        yield "references say their day and trials do not: the trials are taken to be of one day"
    if len(fitted) < 2 and not study.calibrated:
        yield "+- covers only within-run noise; run-to-run variation needs more runs"
    if study.cut:
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


def _of_held_out_runs(named: Sequence[NamedCause], far: HowFar) -> Iterator[str]:
    """How little the causes help to predict held-out runs, with references."""
    if any(far.worse):
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
    if named and far.high < LITTLE:
        most = 100.0 * max(far.high, 0.0)
        yield (
            f"on held-out runs the named causes explain {most:.0f} % of the gap at the most: what is new "
            "may only be like them, or not alone; look at what remains"
        )


def _of_the_test(
    named: Sequence[NamedCause], detection: Detection, selection: Selection
) -> Iterator[str]:
    """What was nearly a cause, or nearly a gap."""
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


def _of_unjudged(named: Sequence[NamedCause], far: HowFar) -> Iterator[str]:
    """Which causes held-out runs do not show."""
    if np.isfinite(far.shrink) and (
        hidden := [place_words(one.effect, one.joints) for one in named if np.isnan(one.last)]
    ):
        yield (
            f"the runs held out for testing do not show {' and '.join(hidden)}, so they cannot judge it; "
            "record another run like the one that shows it"
        )


def _of_a_cause(one: NamedCause, several: int) -> Iterator[str]:
    """What speaks against a cause; ``several`` are named."""
    place = place_words(one.effect, one.joints)
    if one.clear < HALF:
        yield (
            f"{place}: its size is so few of its +- from nothing that, of so many effects, one has as "
            "much by chance"
        )
    if one.trend.surely(several):
        size = 100.0 * one.trend.growth
        yield (
            f"{place} changes by {size:+.0f} % of its size in the course of a run, which no effect of "
            "the catalogue does: look for wear, heat, dust, a battery"
        )
    for value in one.values:
        if value.on_bound:
            yield f"{place}: {value.name} is on its bound: not an effect of this form"


def resembling(left_there: float) -> Iterator[str]:
    """Return that a cause may only resemble the true one, where clearly more is left at its joint."""
    if left_there >= CLEARLY_LEFT:
        yield (
            f"on held-out runs a named cause leaves {np.exp(left_there / 2):.1f} times as much at its "
            "joint as is left at others (RMS): it may only resemble the true one; compare the curves of "
            "that joint"
        )


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
