"""Motions that a run makes once: what references of one show, moment by moment, is expected there."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap.constants import MOTION_HARMONICS
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machines.servo_bench.simulator import servo_bench
from gap.residuals.motions import motions_of
from gap.residuals.part_error import phase_basis
from gap.residuals.parts import whole_parts
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial

HZ, FRAMES = 50.0, 500
TIME_S = np.arange(FRAMES) / HZ
STEPS = np.array([0.0, 0.6, -0.4, 0.9, 0.2, -0.7, 0.5, -0.2])
COMMANDS = {
    "chirp": 0.6 * np.sin(2 * np.pi * (0.2 * TIME_S + 0.08 * TIME_S**2)),
    "steps": STEPS[(TIME_S / 1.25).astype(int)],
}
BENCH = servo_bench([servo_trial(MOTOR, np.zeros(FRAMES), hz=HZ)])


def run(motion: str, seed: int, causes: Sequence[Cause] = (), rubs_rad: float = 0.0) -> Trial:
    """A run of a servo that has dry friction which its file lacks, on a day of its own."""
    draws = np.random.default_rng(seed)
    command = COMMANDS[motion]
    still = named(servo_trial(MOTOR, command, np.zeros(FRAMES), hz=HZ), motion)
    day = (
        Cause("coulomb_friction", ("arm",), (0.10 * (1 + 0.03 * draws.standard_normal()),)),
        Cause("viscous_friction", ("arm",), (0.05 * (1 + 0.03 * draws.standard_normal()),)),
    )
    shaft = command + BENCH.predict(still, [*day, *causes], Drive.COMMAND)[:, 0]
    shaft -= rubs_rad * np.exp(-(((shaft - 0.3) / 0.1) ** 2))
    shaft += draws.normal(0.0, 0.001, FRAMES)
    return named(servo_trial(MOTOR, command, shaft, hz=HZ), motion)


def named(trial: Trial, motion: str) -> Trial:
    return replace(trial, header=replace(trial.header, gait=motion))


def both(seed: int, *causes: Cause, rubs_rad: float = 0.0) -> list[Trial]:
    return [run(name, seed + k, causes, rubs_rad) for k, name in enumerate(COMMANDS)]


REFERENCES = [*both(1), *both(11), *both(21)]


def unlike(trials: Sequence[Trial]) -> list[Trial]:
    """The same, of which no two have the same name."""
    return [named(one, f"{one.header.gait} {k}") for k, one in enumerate(trials)]


def test_motions_that_are_commanded_alike_are_found_with_how_long_they_take() -> None:
    parts = whole_parts(BENCH, REFERENCES)
    assert motions_of(parts, REFERENCES) == {name: pytest.approx(TIME_S[-1]) for name in COMMANDS}
    assert motions_of(parts[:2], REFERENCES[:2]) == {}, "one of each tells nothing"


def test_a_motion_is_none_if_it_is_commanded_otherwise_or_has_cycles() -> None:
    other = replace(REFERENCES[0], command_rad=REFERENCES[0].command_rad[::-1].copy())
    trials = [other, *REFERENCES[1:]]
    assert set(motions_of(whole_parts(BENCH, trials), trials)) == {"steps"}
    cyclic = [replace(t, header=replace(t.header, frequency_hz=0.5)) for t in REFERENCES]
    assert motions_of(whole_parts(BENCH, cyclic), cyclic) == {}


def test_a_longer_trial_does_not_begin_the_motion_again() -> None:
    parts = whole_parts(BENCH, REFERENCES)
    longer = replace(parts[0], observation=replace(parts[0].observation, time_s=2.0 * TIME_S))
    motions = motions_of(parts, REFERENCES, (longer,))
    assert motions["chirp"] == pytest.approx(2.0 * TIME_S[-1])


def test_all_parts_of_a_study_know_their_motion() -> None:
    study = make_study(both(31), BENCH, REFERENCES)
    for part in (*study.fitted, *study.held, *study.references):
        assert part.condition.once
        assert part.cycle[-1] <= 1.0
        assert phase_basis(part).shape[1] == min(1 + 2 * int(MOTION_HARMONICS), part.frames)
    lone = make_study(both(31), BENCH, unlike(REFERENCES))
    assert not any(part.condition.once for part in (*lone.fitted, *lone.references))


def test_what_references_show_at_a_moment_is_not_a_gap_and_what_they_do_not_is() -> None:
    """A shaft that rubs somewhere: its references say where a healthy one is, moment by moment."""
    healthy, rubs = both(31), both(41, rubs_rad=0.02)
    assert diagnose(healthy, BENCH, REFERENCES).verdict is Verdict.NO_GAP
    found = diagnose(rubs, BENCH, REFERENCES)
    assert found.verdict is Verdict.UNEXPLAINED
    hidden = diagnose(rubs, BENCH, unlike(REFERENCES))
    assert hidden.verdict is Verdict.NO_GAP


def test_sizes_that_would_be_detected_are_smaller_by_it() -> None:
    def smallest(references: Sequence[Trial]) -> FloatArray:
        d = diagnose(both(31), BENCH, references)
        sizes = {one.effect: one.size for one in d.detectable}
        return np.array([sizes["load_friction"], sizes["payload"]])

    assert (smallest(REFERENCES) < 0.7 * smallest(unlike(REFERENCES))).all()
