"""What limits a diagnosis is said: what is nearly a gap, what held-out runs refused or hardly show."""

from dataclasses import replace

import numpy as np
import pytest

from gap.constants import ENERGY_LEVEL
from gap.diagnosis.answer.caveats import warnings_of
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.answer.verdict import gap_exists, verdict_of
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from gap.search.candidates import candidates_of
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.options import CAUSE_LEVEL, fit_option
from gap.search.steps import Selection, Step
from tests.gap.toy import LIKE, Toy, toy_case, toy_references, walked_day


def test_a_cause_that_held_out_runs_speak_against_is_a_gap_without_a_name_and_said() -> None:
    trials, known = toy_case(seed=10, wander=0.01), toy_references(10, wander=0.01)
    d = diagnose(trials, Toy(), known)
    assert d.verdict is Verdict.NO_GAP
    study = make_study(trials, Toy(), known)
    shown = Detection(True, 0.02, 0.01, 0.6, 1.0, 0.14, 6)
    evidence = study.evidence(study.local)
    empty = Selection(fit_causes(evidence, ()), np.zeros(len(evidence.starts)), ())
    assert gap_exists(evidence, shown, empty)
    assert not gap_exists(evidence, d.detection, empty)
    assert verdict_of(True, (), 1.0, ()) is Verdict.UNEXPLAINED
    offset = next(one for one in candidates_of(study.simulator) if one.effect.name == "offset")
    refused = fit_option(evidence, offset, (offset.cause((0.01,)),), empty.unseen)
    (said,) = set(
        warnings_of(
            study, 50, (), d.far, shown, replace(empty, refused=(Step(refused, (), 0.003),))
        )
    ) - set(warnings_of(study, 50, (), d.far, d.detection, empty))
    assert said.startswith(f"offset at {offset.joints[0]} (offset_rad ")
    assert (
        "fitted to these runs, is larger than in the references (chance in healthy runs 0.003)"
        in said
    )


@pytest.mark.parametrize(
    ("p_cause", "p_energy", "said"),
    [
        (0.0437, 0.6, "tether (x_n 0."),
        (0.09, 0.6, ""),
        (0.06, 0.3, "tether (x_n 0."),
        (0.3, 0.012, "what is left"),
    ],
)
def test_what_is_nearly_a_gap_is_said(p_cause: float, p_energy: float, said: str) -> None:
    """By a cause or by energies, and not from twice the limit on."""
    study = make_study(toy_case([Cause("tether", (), (0.1,))], 3), Toy(), toy_references(3))
    evidence = study.evidence(study.local)
    empty = fit_causes(evidence, ())
    tether = next(one for one in candidates_of(study.simulator) if one.effect.name == "tether")
    nearest = fit_option(evidence, tether, (tether.cause((0.1,)),), unseen_score(evidence, empty))
    far = diagnose(toy_case(seed=3), Toy(), toy_references(3)).far
    p = 0.05 * min(p_cause / CAUSE_LEVEL, p_energy / ENERGY_LEVEL)
    shown = Detection(False, p, p_cause, p_energy, 1.0, 0.14, 6, "speed")
    looked = Selection(empty, np.zeros(len(evidence.starts)), (), nearest=nearest)
    noted = warnings_of(study, 50, (), far, shown, looked)
    words = [one for one in noted if "nearly" in one]
    assert len(words) == bool(said)
    if said:
        assert words[0].startswith(f"nearly a gap: {said}")
        assert f". {100 * p:.2g} % of healthy sets" in words[0]
        assert said.startswith("tether") or "most in speed. " in words[0]


@pytest.mark.parametrize(
    ("ratio", "verdict", "said"),
    [(0.95, Verdict.NO_GAP, False), (0.85, Verdict.NO_GAP, True), (0.8, Verdict.EXPLAINED, False)],
)
def test_a_cause_that_days_nearly_hide_is_named_as_nearly_a_gap(
    ratio: float, verdict: Verdict, said: bool
) -> None:
    softer = (Cause("stiffness", ("c",), (ratio,)),)
    trials = [walked_day(k, 100 + k, LIKE, softer) for k in range(4)]
    d = diagnose(trials, Toy(), [walked_day(k, k, LIKE) for k in range(6)])
    assert d.verdict is verdict
    nearly = [one for one in d.warnings if one.startswith("nearly a gap: ")]
    assert len(nearly) == said
    assert not said or "nearly a gap: stiffness at c (ratio 0.8" in nearly[0]


def test_causes_that_close_little_on_held_out_runs_are_said_to() -> None:
    causes = [Cause("tether", (), (2.0,))]
    trials, known = toy_case(causes, seed=3), toy_references(3)
    d = diagnose(trials, Toy(), known)
    study = make_study(trials, Toy(), known)
    evidence = study.evidence(study.local)
    assert d.far.low > 0.5

    def said(low: float, high: float) -> set[str]:
        far = replace(d.far, shrink=0.5 * (low + high), low=low, high=high)
        nothing = Selection(fit_causes(evidence, ()), np.zeros(len(evidence.starts)), ())
        return set(warnings_of(study, 50, d.causes, far, d.detection, nothing)) - set(d.warnings)

    (words,) = said(-0.14, 0.2)
    assert "explain 20 % of the gap at the most" in words
    assert not said(-0.14, 0.3)
    assert not said(np.nan, np.nan)
