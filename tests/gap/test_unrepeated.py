"""What is another in each cycle, and what comes back in each."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.caveats import warnings_of
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.residuals.parts import TrialPart, whole_parts
from gap.residuals.unrepeated import PHASES, unrepeated
from gap.search.fit import fit_causes
from gap.search.steps import Selection
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import NOISE, Toy, toy_case, toy_references, toy_trial


@pytest.fixture(scope="module")
def part() -> TrialPart:
    trial = toy_trial([], 0.0, "trot", seconds=60.0, seed=1)
    (part,) = whole_parts(Toy(), [trial], 1)
    cycle = np.linspace(0.3, 6.3, part.frames)
    return replace(part, observation=replace(part.observation, cycle=cycle))


def _noise(part: TrialPart, channels: int = 2) -> FloatArray:
    return np.random.default_rng(1).standard_normal((part.frames, channels))


def test_what_comes_back_in_each_cycle_is_nothing(part: TrialPart) -> None:
    """It is far larger than noise, and so is what two references leave of each other."""
    phase = np.floor(np.mod(part.observation.cycle, 1.0) * PHASES)
    wave = 50.0 * np.cos(2 * np.pi * phase / PHASES)[:, None]
    noise = _noise(part)
    assert unrepeated(part, noise + wave) == pytest.approx(unrepeated(part, noise))


def test_noise_is_the_variance_of_a_phase_s_mean(part: TrialPart) -> None:
    cycles = abs(np.ptp(part.observation.cycle))
    in_a_phase = part.frames / cycles / PHASES
    assert unrepeated(part, _noise(part)) == pytest.approx(1.0 / in_a_phase, rel=0.4)


def test_a_knock_in_one_cycle_is_plain_in_the_channel_that_feels_it(part: TrialPart) -> None:
    noise = _noise(part)
    knocked = noise.copy()
    at = part.frames // 2
    knocked[at : at + part.frames // 20, 1] += 20.0
    calm, plain = unrepeated(part, knocked) / unrepeated(part, noise)
    assert calm == pytest.approx(1.0)
    assert plain > 20.0


def test_without_cycles_or_without_two_of_them_nothing_is_known(part: TrialPart) -> None:
    noise = _noise(part)
    first = int(np.searchsorted(part.observation.cycle - part.observation.cycle[0], 0.9))
    assert np.isnan(unrepeated(part, noise[:first])).all()
    still = replace(part.observation, cycle=np.full(part.frames, np.nan))
    assert np.isnan(unrepeated(replace(part, observation=still), noise)).all()
    noise[:, 0] = 0.0  # not measured
    assert list(np.isnan(unrepeated(part, noise))) == [True, False]


def _knocked(trial: Trial, seed: int) -> Trial:
    """Knocks of a fifth of a second, at any time and to either side: their mean is little."""
    rng = np.random.default_rng(seed)
    place = trial.body_position_m.copy()
    for at in rng.uniform(0.5, trial.time_s[-1] - 0.5, 12):
        place[abs(trial.time_s - at) < 0.1, 0] += 4.0 * NOISE["speed"] * rng.choice([-1.0, 1.0])
    return replace(trial, body_position_m=place)


def test_knocks_are_a_gap_that_no_constant_cause_explains() -> None:
    known = toy_references(3)
    trials = [_knocked(one, seed) for seed, one in enumerate(toy_case((), 3))]
    d = diagnose(trials, Toy(), known)
    assert d.verdict is Verdict.UNEXPLAINED, d.sentence
    assert d.detection is not None
    assert d.detection.by_energy
    assert d.detection.energy_in == "speed"


@pytest.mark.parametrize(
    ("p", "verdict"), [(0.001, "is a gap"), (0.015, "is nearly one"), (0.5, "")]
)
def test_what_differs_from_cycle_to_cycle_is_said(p: float, verdict: str) -> None:
    trials, known = toy_case((), 3), toy_references(3)
    d = diagnose(trials, Toy(), known)
    assert d.detection is not None
    study = make_study(trials, Toy(), known)
    evidence = study.evidence(study.local)
    none = Selection(fit_causes(evidence, ()), np.zeros(len(evidence.starts)), ())
    shown = replace(
        d.detection,
        below=p < 0.01,
        p=5 * p,
        p_energy=p,
        p_cause=1.0,
        energy_in="speed",
        in_cycles=True,
    )
    noted = [
        one for one in warnings_of(study, 50, (), d.far, shown, none) if "cycle to cycle" in one
    ]
    assert len(noted) == bool(verdict)
    if verdict:
        assert "more than in references, most in speed" in noted[0]
        assert noted[0].startswith("nearly a gap: ") is (verdict == "is nearly one")
        assert ("look for something loose" in noted[0]) is (verdict == "is a gap")


def test_a_healthy_machine_is_told_nothing_of_cycles() -> None:
    d = diagnose(toy_case((), 3), Toy(), toy_references(3))
    assert d.verdict is Verdict.NO_GAP
    assert not any("from cycle to cycle" in one for one in d.warnings)
