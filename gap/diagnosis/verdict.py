"""The verdict, the causes with their evidence, and all of it in words."""

from collections.abc import Mapping, Sequence

import numpy as np

from gap.diagnosis.ambiguity import Alike
from gap.diagnosis.findings import Diagnosis, NamedCause, TrialFaults, Value, Verdict
from gap.diagnosis.how_far import HowFar
from gap.diagnosis.probability import Chance
from gap.interfaces import Cause, Effect, place_words
from gap.residuals.evidence import Evidence
from gap.residuals.parts import Part
from gap.rounding import percent_words, value_words
from gap.search.selection import Selection
from gap.search.standard_errors import standard_errors
from model.values.arrays import FloatArray
from record.trial.trial import Trial

FEW_BLOCKS = 6
FEWEST_REFERENCES = 3  # from which how healthy runs differ is told
NONE_LIKELY = 0.5


def verdict_of(
    exists: bool, selection: Selection, none: float, open_rivals: Sequence[Alike]
) -> Verdict:
    """Choose among the four."""
    if not exists:
        return Verdict.NO_GAP
    if not selection.steps or none > NONE_LIKELY:
        return Verdict.UNEXPLAINED
    return Verdict.AMBIGUOUS if open_rivals else Verdict.EXPLAINED


def named_causes(
    evidence: Evidence,
    selection: Selection,
    effects: Mapping[str, Effect],
    shared: Sequence[Sequence[Chance]],
    far: HowFar,
    healthy: Evidence | None = None,
) -> tuple[NamedCause, ...]:
    """Return the causes with everything known of them, the one that closes most first."""
    errors = standard_errors(evidence, healthy, selection.fitted)
    found, at = [], 0
    parts = _parts(far, len(selection.steps))
    for number, (cause, step) in enumerate(
        zip(selection.fitted.causes, selection.steps, strict=True)
    ):
        effect = effects[cause.effect]
        size = len(effect.parameters)
        values = _values(effect, cause, errors[at : at + size])
        at += size
        found.append(
            NamedCause(
                effect=cause.effect,
                joints=cause.joints,
                stage=effect.stage,
                values=values,
                probability=shared[number][0].probability,
                nats=step.chosen.over.nats,
                nats_error=step.chosen.over.error,
                shrink=parts[number],
                alone=far.alone[number],
                last=far.last[number],
                physics=effect.physics,
                remedy=effect.remedy,
            )
        )
    return tuple(sorted(found, key=lambda one: -np.nan_to_num(one.shrink, nan=0.0)))


def _parts(far: HowFar, count: int) -> list[float]:
    """Each cause's part of what all close: the mean of first and last in, made to add up."""
    if not np.isfinite(far.shrink):
        return [np.nan] * count
    raw = [0.5 * (a + b) for a, b in zip(far.alone, far.last, strict=True)]
    total = sum(raw)
    return [r * far.shrink / total if total > 0 else np.nan for r in raw]


def _values(effect: Effect, cause: Cause, errors: FloatArray) -> tuple[Value, ...]:
    out = []
    for p, value, error in zip(effect.parameters, cause.values, errors, strict=True):
        edge = 1e-6 * (p.upper - p.lower)
        bound = not p.lower + edge < value < p.upper - edge
        out.append(Value(p.name, p.unit, value, float(error) * p.spread, p.neutral, bound))
    return tuple(out)


def cause_words(one: NamedCause) -> str:
    """Name a cause with its place and size."""
    sizes = ", ".join(
        f"{v.name} {value_words(v.value, v.error)}" + (" (on its bound)" if v.on_bound else "")
        for v in one.values
    )
    return place_words(one.effect, one.joints) + (f" ({sizes})" if sizes else "")


def sentence(d: Diagnosis) -> str:
    """Say the verdict in one sentence."""
    if d.verdict is Verdict.NO_GAP:
        above = (
            "what the references show"
            if d.floor_source == "references"
            else "noise and repeatability"
        )
        return f"No gap above {above}."
    shrunk = ""
    if np.isfinite(d.far.shrink):
        added = "it" if len(d.causes) == 1 else "them"
        shrunk = f"; adding {added} closes {percent_words(d.far.shrink)} of the gap"
        shrunk += f" [{percent_words(d.far.low)}, {percent_words(d.far.high)}] on {d.kept_back}"
    names = " and ".join(cause_words(one) for one in d.causes)
    if d.verdict is Verdict.EXPLAINED:
        return f"The simulator lacks {names}{shrunk}."
    if d.verdict is Verdict.AMBIGUOUS:
        return f"The simulator lacks {names}{shrunk}. These runs cannot tell {_open_words(d)}."
    place = f" in the stage {d.where.stage}" if d.where.stage else ""
    if not d.causes:
        return f"There is a gap{place}, and no effect of the catalogue reduces it."
    return (
        f"There is a gap{place} that the catalogue does not explain; {names} comes nearest"
        f" and closes {percent_words(d.closed)} of it in the fitted runs."
    )


def _open_words(d: Diagnosis) -> str:
    """Each cause that has open rivals, with its own."""
    rivals: dict[str, list[str]] = {}
    for one, of in zip(d.ambiguous, d.ambiguous_of, strict=True):
        rivals.setdefault(place_words(*of), []).append(place_words(one.effect, one.joints))
    return ", and not ".join(f"{of} from {' or '.join(own)}" for of, own in rivals.items())


def warnings_of(
    faults: Sequence[TrialFaults],
    references: Sequence[Trial],
    evidence: Evidence,
    fitted: Sequence[Part],
    held: Sequence[Part],
    named: Sequence[NamedCause],
) -> tuple[str, ...]:
    """Say what limits the diagnosis."""
    out = []
    severe = [f for one in faults for f in one.faults if f.severe]
    if severe:
        channels = ", ".join(sorted({f.channel for f in severe}))
        out.append(f"mend the data first ({channels}): what follows cannot be trusted")
    if not references:
        out.append(
            "no reference runs: what the simulator always lacks cannot be told from what is new"
        )
    elif len(references) < FEWEST_REFERENCES:
        out.append("fewer than 3 references: no chance of a false alarm can be given")
    if len({part.trial for part in fitted}) < 2 and len(references) < FEWEST_REFERENCES:
        out.append("+- is of the noise in one run: how much runs differ cannot be told from one")
    if {part.trial for part in fitted} & {part.trial for part in held}:
        out.append("one trial a gait: the last third of each judges what was fitted to the rest")
    if len(evidence.starts) < FEW_BLOCKS:
        out.append(f"only {len(evidence.starts)} blocks to fit to; record longer runs")
    gaits = {part.gait for part in fitted}
    if references and not gaits <= {one.header.gait for one in references}:
        out.append("a gait has no reference: its expectation is wide")
    out += [
        f"{place_words(one.effect, one.joints)}: {value.name} is on its bound: not an effect of this form"
        for one in named
        for value in one.values
        if value.on_bound
    ]
    return tuple(out)
