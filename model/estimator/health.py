"""Whether the estimate may be relied on, and why not."""

from dataclasses import dataclass, field

from model.estimator.settings import EstimatorSettings
from model.values.estimate import EstimatorState, Health

NEVER = -1
# Mean normalised innovation squared over its degrees of freedom beyond which noise and model are at
# odds; far wider than a statistical band, which no model of the real ground stays in.
NIS_TOP = 4.0


@dataclass(slots=True)
class Trouble:
    """Reasons collected on the way through a step."""

    reasons: list[str] = field(default_factory=list)

    def add(self, reason: str) -> None:
        """Add a reason."""
        self.reasons.append(reason)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Health, the reason in words, and what the next step has to know of it.

    Attributes:
        health: Health.
        reason: Why it is not ok; empty if it is.
        fine_ns: Since when all has been in order, -1 if it is not.
        lost: Whether the estimate is lost.
    """

    health: Health
    reason: str
    fine_ns: int
    lost: bool


@dataclass(frozen=True, slots=True)
class Moment:
    """What a step is judged by.

    Attributes:
        t_ns: Its time.
        force_ns: Time of the newest force record, -1 for none.
        answer_ns: Last time that the model had an answer, -1 for never.
        nis: Mean normalised innovation squared over degrees of freedom; NaN if unknown.
        absolute: Whether an absolute pose was heard: then nothing is lost.
    """

    t_ns: int
    force_ns: int
    answer_ns: int
    nis: float
    absolute: bool


def judge(
    before: EstimatorState, moment: Moment, settings: EstimatorSettings, trouble: Trouble
) -> Verdict:
    """Judge a step.

    Args:
        before: State before it: since when all is fine, and whether all was lost.
        moment: What there is to judge.
        settings: Limits.
        trouble: What happened in it; the checks here add to it.
    """
    if moment.force_ns != NEVER:
        age_s = (moment.t_ns - moment.force_ns) * 1e-9
        if age_s > settings.stale_force_s:
            trouble.add(f"no forces for {age_s:.1f} s")
    if moment.nis > NIS_TOP:
        trouble.add(f"forces are not what the model expects: NIS {moment.nis:.1f} a number")
    silent_s = (moment.t_ns - moment.answer_ns) * 1e-9 if moment.answer_ns != NEVER else 0.0
    lost = (before.lost or silent_s > settings.lost_after_s) and not moment.absolute
    fine_ns = NEVER
    if not trouble.reasons:
        fine_ns = before.fine_ns if before.fine_ns != NEVER else moment.t_ns
        lost = lost and (moment.t_ns - fine_ns) * 1e-9 < settings.recover_s
    words = "; ".join(trouble.reasons)
    if lost:
        words = words or "the feet have only just begun to carry again"
        return Verdict(Health.LOST, words, fine_ns, lost=True)
    return Verdict(Health.DEGRADED if words else Health.OK, words, fine_ns, lost=False)
