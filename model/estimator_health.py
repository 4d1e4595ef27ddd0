"""Whether the estimate may be relied on, and why not."""

from dataclasses import dataclass, field, replace

import numpy as np

from model.estimator_settings import EstimatorSettings
from model.estimator_types import EstimatorState, Health

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
    """Health, and the reason in words."""

    health: Health
    reason: str


def judge(
    state: EstimatorState, settings: EstimatorSettings, trouble: Trouble, absolute: bool
) -> tuple[EstimatorState, Verdict]:
    """Judge a step; the state returned remembers since when all is fine and whether all is lost.

    Args:
        state: State after the step.
        settings: Limits.
        trouble: What happened in it; the checks here add to it.
        absolute: Whether an absolute pose was heard: then nothing is lost.
    """
    if state.force_ns != NEVER:
        age_s = (state.t_ns - state.force_ns) * 1e-9
        if age_s > settings.stale_force_s:
            trouble.add(f"no forces for {age_s:.1f} s")
    if np.isfinite(state.nis) and state.nis > NIS_TOP:
        trouble.add(f"forces are not what the model expects: NIS {state.nis:.1f} a number")
    silent_s = (state.t_ns - state.answer_ns) * 1e-9 if state.answer_ns != NEVER else 0.0
    lost = (state.lost or silent_s > settings.lost_after_s) and not absolute
    if trouble.reasons:
        state = replace(state, fine_ns=NEVER, lost=lost)
    else:
        since = state.fine_ns if state.fine_ns != NEVER else state.t_ns
        settled = (state.t_ns - since) * 1e-9 >= settings.recover_s
        state = replace(state, fine_ns=since, lost=lost and not settled)
    words = "; ".join(trouble.reasons)
    if state.lost:
        return state, Verdict(Health.LOST, words or "the feet have only just begun to carry again")
    return state, Verdict(Health.DEGRADED if words else Health.OK, words)
