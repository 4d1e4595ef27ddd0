"""What a diagnosis finds, as values, and its verdict in one sentence."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from gap.constants import FALSE_ALARMS, NONE_LIKELY
from gap.detectable import Detectable
from gap.diagnosis.alternatives.ambiguity import OpenRival
from gap.diagnosis.alternatives.probability import Fit, RivalCause
from gap.diagnosis.answer.named_cause import NamedCause, names_of
from gap.diagnosis.comparison.baselines import Baseline
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.how_far import HowFar
from gap.diagnosis.comparison.new_commands import NewCommands
from gap.diagnosis.comparison.trend import RunChange
from gap.diagnosis.comparison.where import Where
from gap.experiments.next_run import NextRun
from gap.interfaces import Cause, DataFault, place_words
from gap.residuals.hunting import Hunting
from gap.rounding import percent_words

DATA_FIRST = "Fix the data first"
NO_BETTER = "does not improve the prediction of held-out runs"


class Verdict(Enum):
    """The four answers."""

    NO_GAP = "no_gap"
    EXPLAINED = "explained"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"

    @property
    def headline(self) -> str:
        """In capitals, as a report shows it."""
        return self.value.upper().replace("_", " ")


def improves(share: float) -> bool:
    """Whether a share of the gap is one that can be named: it is known, and not 0 % or less."""
    return share >= 0.005


def change_words(one: RunChange) -> str:
    """Say what changes in the course of each run, by how much, and what else it may be."""
    change = f"{one.parameter} by about {one.change:+.2g} {one.unit}".strip()
    others = "".join(f", or {place_words(*other)}" for other in one.alike)
    place = place_words(one.effect, one.joints)
    return f"{place}{others} changes while the machine runs ({change} from start to end)"


@dataclass(frozen=True, slots=True)
class TrialFaults:
    """Data faults of one trial, by its number; references are behind the trials."""

    trial: int
    faults: tuple[DataFault, ...]


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Everything that a diagnosis finds.

    Attributes:
        stage: Where the gap lies; empty if there is none.
        data_faults: What is wrong with the data.
        standing: What the references show already, and every prediction has.
        floor_source: ``references``, ``cycles`` or ``sensors``.
        detection: Whether there is a gap; None without enough references.
        change: What changes in the course of a run, if that is a gap and no cause is named; else None.
        hunting: Joints that hunt as in no reference; what they read meanwhile was not compared.
        hunts_for_nothing: Those of them for which no cause was found.
        causes: Causes, the largest first.
        rivals: Alternatives fitted in their place.
        ambiguous: Alternatives that these runs leave open.
        none: Probability that the catalogue has no name for it.
        fit: What the causes explain in the fitted trials.
        far: Before and after on held-out trials.
        fitted_trials: Numbers of the trials that were fitted to.
        held_out_trials: Numbers of those that judged.
        baselines: Answers of simpler methods.
        detectable: Smallest sizes that would have shown.
        next: The best runs to discriminate between candidates.
        new_commands: The trial that is commanded as no reference was; None if there is none.
        predictions: How many trials were simulated.
    """

    simulator: str
    verdict: Verdict
    stage: str
    data_faults: tuple[TrialFaults, ...]
    standing: tuple[Cause, ...]
    floor_source: str
    detection: Detection | None
    change: RunChange | None
    hunting: tuple[Hunting, ...]
    hunts_for_nothing: tuple[Hunting, ...]
    causes: tuple[NamedCause, ...]
    rivals: tuple[RivalCause, ...]
    ambiguous: tuple[OpenRival, ...]
    none: float
    fit: Fit
    where: Where
    remaining: Where
    far: HowFar
    fitted_trials: tuple[int, ...]
    held_out_trials: tuple[int, ...]
    baselines: tuple[Baseline, ...]
    detectable: tuple[Detectable, ...]
    next: tuple[NextRun, ...]
    new_commands: NewCommands | None
    warnings: tuple[str, ...]
    predictions: int
    seed: int

    @property
    def severe_channels(self) -> tuple[str, ...]:
        """Channels with a severe fault of the data: until it is fixed, no answer can be trusted."""
        severe = {f.channel for one in self.data_faults for f in one.faults if f.severe}
        return tuple(sorted(severe))

    @property
    def headline(self) -> str:
        """The verdict in capitals; or that the data come first."""
        return DATA_FIRST.upper() if self.severe_channels else self.verdict.headline

    @property
    def sentence(self) -> str:
        """The verdict in one sentence; behind a warning where the data have a severe fault."""
        if not self.severe_channels:
            return self._answer
        first, answer = ", ".join(self.severe_channels), self._answer
        return (
            f"{DATA_FIRST} ({first}): what follows cannot be trusted. With the data as they are: "
            f"{answer[0].lower()}{answer[1:]}"
        )

    @property
    def _answer(self) -> str:
        if self.verdict is Verdict.NO_GAP:
            known = self.floor_source == "references"
            above = "what the references show" if known else "noise and repeatability"
            return f"No gap above {above}."
        if self.verdict is Verdict.EXPLAINED:
            return f"{self._lacks(self.sure)}.{self._perhaps}{self._new_ground}"
        if self.verdict is Verdict.AMBIGUOUS:
            return (
                f"{self._lacks(self.causes)}. These runs cannot distinguish {self._open_words}."
                f"{self._new_ground}"
            )
        if self.change is not None:
            return (
                f"There is a gap in the stage {self.change.stage}: {change_words(self.change)}. References "
                "do not show this. Look for wear, heat, dust, a battery."
            )
        if self.hunts_for_nothing and not self.causes:
            return (
                f"There is a gap in the stage {self.stage}: {self._hunting_words}. Look for play in its "
                "gears, or too high a gain of its loop."
            )
        place = f" in the stage {self.where.stage}" if self.where.stage else ""
        if not self.causes:
            nothing = "and no effect of the catalogue reduces it on held-out runs"
            return f"There is a gap{place}, {nothing}.{self._new_ground}"
        one, share = len(self.causes) == 1, percent_words(self.fit.closed)
        comes, explains = ("comes", "explains") if one else ("come", "explain")
        much = (
            f"{explains} {share} of it" if improves(self.fit.closed) else f"{explains} none of it"
        )
        return (
            f"There is a gap{place} that the catalogue does not explain; {names_of(self.causes)} {comes} "
            f"closest and {much} in the fitted runs{self._worse_held_out}.{self._new_ground}"
        )

    @property
    def _worse_held_out(self) -> str:
        """That held-out runs are surely predicted worse with the causes, end to end."""
        if not self.far.surely_worse:
            return ""
        verb = "is" if self.far.runs == 1 else "are"
        with_them = "with it" if len(self.causes) == 1 else "with them"
        fed = "from commands alone " if self.far.end_to_end else ""
        return f", but {fed}{self.held_out} {verb} predicted worse {with_them}"

    @property
    def _hunting_words(self) -> str:
        return "; ".join(one.words for one in self.hunts_for_nothing)

    @property
    def no_cause_words(self) -> str:
        """Say, where no cause is named, what there is instead."""
        if self.hunts_for_nothing:
            return self._hunting_words
        if self.change is None:
            return "no effect of the catalogue reduces it"
        return f"none by its mean; {change_words(self.change)}"

    def _lacks(self, listed: Sequence[NamedCause]) -> str:
        """What the simulator lacks, and how much of the gap is explained with it."""
        names = names_of(listed)
        if self.severe_channels:
            lacks = f"{names} {'fits' if len(listed) == 1 else 'fit'} best"
        else:
            lacks = f"The simulator lacks {names}"
        far = self.far
        if not np.isfinite(far.shrink):
            return lacks
        if len(listed) < len(self.causes):
            added = "adding all named causes"
        else:
            added = "adding it" if len(listed) == 1 else "adding them"
        if not improves(far.shrink):
            return f"{lacks}; {added} {NO_BETTER}"
        within = f"{percent_words(far.low)}, {percent_words(far.high)}"
        share = f"explains {percent_words(far.shrink)} of the gap [{within}]"
        return f"{lacks}; {added} {share} on {self.held_out}"

    @property
    def _new_ground(self) -> str:
        """What a gap may be where no reference was commanded like the trials."""
        if self.new_commands is None:
            return ""
        return (
            f" But no reference was commanded like {self.new_commands.runs}: a healthy machine may show "
            "this too. Record references with the same commands."
        )

    @property
    def in_doubt(self) -> tuple[NamedCause, ...]:
        """Causes that have open alternatives."""
        doubted = {one.of for one in self.ambiguous}
        return tuple(one for one in self.causes if (one.effect, one.joints) in doubted)

    @property
    def sure(self) -> tuple[NamedCause, ...]:
        """Causes that have none."""
        return tuple(one for one in self.causes if one not in self.in_doubt)

    @property
    def acted_on(self) -> tuple[NamedCause, ...]:
        """Causes that a person does something about: none of data with a fault, none that hardly is one."""
        if self.severe_channels or self.verdict is Verdict.NO_GAP:
            return ()
        if self.verdict is Verdict.EXPLAINED:
            return self.sure
        if self.verdict is Verdict.AMBIGUOUS:
            return self.causes
        return tuple(one for one in self.causes if one.probability > NONE_LIKELY)

    @property
    def _perhaps(self) -> str:
        """What an ``explained`` has besides, that explains next to nothing and may be something else."""
        if not self.in_doubt:
            return ""
        share, names = sum(one.shrink for one in self.in_doubt), names_of(self.in_doubt)
        one = len(self.in_doubt) == 1
        cannot = f"these runs cannot distinguish {self._open_words}."
        if improves(share):
            return f" Of this, {percent_words(share)} may be {names}: {cannot}"
        better = NO_BETTER if one else NO_BETTER.replace("does", "do")
        return f" {names} {'is' if one else 'are'} named too, but {better}: {cannot}"

    @property
    def _open_words(self) -> str:
        """Each cause that has open alternatives, with its own."""
        rivals: dict[str, list[str]] = {}
        for one in self.ambiguous:
            words = place_words(one.effect, one.joints)
            rivals.setdefault(place_words(*one.of), []).append(words)
        return ", and not ".join(f"{of} from {' or '.join(own)}" for of, own in rivals.items())

    @property
    def held_out(self) -> str:
        """What was held out to judge, in words."""
        shared = set(self.fitted_trials) & set(self.held_out_trials)
        if not shared:
            runs = self.far.runs
            return "a held-out run" if runs == 1 else f"{runs} held-out runs"
        return "the last third of the run" if len(shared) == 1 else "the last third of each run"

    @property
    def false_alarm_words(self) -> str:
        """How often a healthy robot is reported to have a gap, as far as references can guarantee it."""
        if self.detection is None:
            return "without three references the false-alarm rate cannot be estimated"
        if self.new_commands is not None:
            return f"false-alarm rate: not known, because {self.new_commands.words}"
        return (
            f"false-alarm rate: aimed at {percent_words(float(FALSE_ALARMS))}; "
            f"{self.detection.references_words} alone can guarantee no less than "
            f"{percent_words(self.detection.by_count)}"
        )

    @property
    def interval_words(self) -> str:
        """What an interval over held-out data is over."""
        if set(self.fitted_trials) & set(self.held_out_trials):
            return "interval over cycles; no interval over runs"
        if self.far.over_runs:
            return f"interval over {self.far.runs} held-out runs"
        runs = "one held-out run" if self.far.runs == 1 else f"{self.far.runs} held-out runs"
        return f"interval over the cycles of {runs}; no interval over runs"
