"""Whether the estimate may be relied on, and why not."""

from dataclasses import dataclass

from model.estimator.settings import EstimatorSettings
from model.values.estimate import NEVER, EstimatorState, Health, OdometryInputs

# Mean normalised innovation squared over its degrees of freedom beyond which noise and model are at
# odds; far wider than a statistical band, which no model of the real ground stays in.
NIS_TOP = 4.0


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


def judge(
    before: EstimatorState,
    inputs: OdometryInputs,
    force_ns: int,
    answer_ns: int,
    nis: float,
    settings: EstimatorSettings,
    trouble: list[str],
) -> Verdict:
    """Judge a step.

    Args:
        before: State before it: since when all is fine, and whether all was lost.
        inputs: What was known in it; with an absolute pose nothing is lost.
        force_ns: Time of the newest force record, -1 for none.
        answer_ns: Last time that the model had an answer, -1 for never.
        nis: Mean normalised innovation squared over degrees of freedom; NaN if unknown.
        settings: Limits.
        trouble: What happened in it; the checks here add to it.
    """
    if force_ns != NEVER:
        age_s = (inputs.t_ns - force_ns) * 1e-9
        if age_s > settings.stale_force_s:
            trouble.append(f"no forces for {age_s:.1f} s")
    if nis > NIS_TOP:
        trouble.append(f"forces are not what the model expects: NIS {nis:.1f} a number")
    silent_s = (inputs.t_ns - answer_ns) * 1e-9 if answer_ns != NEVER else 0.0
    lost = (before.lost or silent_s > settings.lost_after_s) and inputs.pose_W is None
    fine_ns = NEVER
    if not trouble:
        fine_ns = before.fine_ns if before.fine_ns != NEVER else inputs.t_ns
        lost = lost and (inputs.t_ns - fine_ns) * 1e-9 < settings.recover_s
    words = "; ".join(trouble)
    if lost:
        words = words or "the feet have only just begun to carry again"
        return Verdict(Health.LOST, words, fine_ns, lost=True)
    return Verdict(Health.DEGRADED if words else Health.OK, words, fine_ns, lost=False)
