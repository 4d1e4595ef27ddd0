"""What a diagnosis says, as values."""

from dataclasses import dataclass
from enum import Enum

from gap.diagnosis.ambiguity import Alike
from gap.diagnosis.baselines import Baseline
from gap.diagnosis.detection import Detectable, Detection
from gap.diagnosis.how_far import HowFar
from gap.diagnosis.where import Where
from gap.experiments.next_run import NextRun
from gap.interfaces import Cause, DataFault


class Verdict(Enum):
    """The four answers."""

    NO_GAP = "no_gap"
    EXPLAINED = "explained"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"


@dataclass(frozen=True, slots=True)
class Value:
    """One fitted number.

    Attributes:
        name: Parameter.
        unit: Its unit.
        value: Fitted value.
        error: Standard error.
        neutral: Value at which nothing happens.
        on_bound: Whether it lies on its bound: then the effect is not of this form.
    """

    name: str
    unit: str
    value: float
    error: float
    neutral: float
    on_bound: bool


@dataclass(frozen=True, slots=True)
class NamedCause:
    """A cause that was found.

    Attributes:
        effect: Its name.
        joints: Where; empty for the whole machine.
        stage: Its stage.
        values: Its numbers.
        probability: That it is this one.
        nats: How much better unseen blocks are predicted with it.
        nats_error: Standard error of that.
        shrink: Its part of what the causes close together on held-out trials; NaN if not measured.
        alone: What it closes by itself.
        last: What it adds to the others.
        physics: What happens.
        remedy: What to check or change.
    """

    effect: str
    joints: tuple[str, ...]
    stage: str
    values: tuple[Value, ...]
    probability: float
    nats: float
    nats_error: float
    shrink: float
    alone: float
    last: float
    physics: str
    remedy: str


@dataclass(frozen=True, slots=True)
class RivalCause:
    """A candidate that was fitted and not taken.

    Attributes:
        cause: Number of the cause it was a rival of.
        effect: Its name.
        joints: Where.
        probability: That it is this one instead.
        behind: Nats by which it predicts unseen blocks worse.
        behind_error: Standard error of that.
        of: Effect and joints of the cause it was a rival of.
    """

    cause: int
    effect: str
    joints: tuple[str, ...]
    probability: float
    behind: float
    behind_error: float
    of: tuple[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class TrialFaults:
    """Data faults of one trial.

    Attributes:
        trial: Its number, references behind the trials.
        faults: What is wrong with its data.
    """

    trial: int
    faults: tuple[DataFault, ...]


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Everything that a diagnosis says.

    Attributes:
        simulator: Name of the simulator.
        verdict: The answer.
        sentence: The answer in words.
        stage: Where the gap lies; empty if there is none.
        data_faults: What is wrong with the data.
        standing: What the references show already, and every prediction has.
        floor_source: ``references``, ``cycles`` or ``sensors``.
        detection: Whether there is a gap; None without enough references to tell.
        causes: Causes, the largest first.
        rivals: Candidates fitted in their place.
        ambiguous: Rivals that these runs leave open.
        ambiguous_of: Effect and joints of the cause that each of them is a rival of.
        none: Probability that the catalogue has no name for it.
        closed: Share of the explainable gap closed, by cross-validation in the fitted trials.
        left: Energy over expectation that is left there.
        left_worst: The same of the worst channel.
        left_p: Chance of so much left in a healthy machine; 0 where there is none to compare with.
        left_nats: Score that is left there beyond that of a healthy machine.
        excess: Energy over expectation before.
        where: The map before.
        remaining: The map of what is left.
        far: Before and after on held-out trials.
        fitted_trials: Numbers of the trials that were fitted to.
        held_out_trials: Numbers of those that judged.
        baselines: What simpler ways would have said.
        detectable: Smallest sizes that would have shown.
        next: Which runs would tell candidates apart.
        warnings: What limits all this.
        predictions: How many trials were simulated.
        seed: Seed.
    """

    simulator: str
    verdict: Verdict
    sentence: str
    stage: str
    data_faults: tuple[TrialFaults, ...]
    standing: tuple[Cause, ...]
    floor_source: str
    detection: Detection | None
    causes: tuple[NamedCause, ...]
    rivals: tuple[RivalCause, ...]
    ambiguous: tuple[Alike, ...]
    ambiguous_of: tuple[tuple[str, tuple[str, ...]], ...]
    none: float
    closed: float
    left: float
    left_worst: float
    left_p: float
    left_nats: float
    excess: float
    where: Where
    remaining: Where
    far: HowFar
    fitted_trials: tuple[int, ...]
    held_out_trials: tuple[int, ...]
    baselines: tuple[Baseline, ...]
    detectable: tuple[Detectable, ...]
    next: tuple[NextRun, ...]
    warnings: tuple[str, ...]
    predictions: int
    seed: int

    @property
    def kept_back(self) -> str:
        """What was kept back to judge, in words."""
        shared = set(self.fitted_trials) & set(self.held_out_trials)
        if not shared:
            return "runs kept back"
        return "the last third of the run" if len(shared) == 1 else "the last third of each run"
