"""What vibrates tells effects apart that predict the same: feet that stick and slip from feet that grip."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.constants import MEAN_DIFFERS, VIBRATION_CLEAR
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Channel, Observation
from gap.residuals.parts import TrialPart
from gap.residuals.vibration import ChannelVibration, vibration_of
from model.effects.causes import Shaking
from robot.gap_report.summary import summary_lines
from tests.gap.toy import CHATTER, EFFECTS, SPEED_GAIN, Toy, toy_case, toy_references

SHAKING = Shaking(("side",), (("load",),), ())
CHANNELS = (Channel("side", "a", "", "N"), Channel("load", "a", "", "N"))
TOY = Toy((*EFFECTS, SPEED_GAIN, CHATTER))


def run(
    seed: int, side: float = 0.1, load: float = 0.1, size: float = 3.0, hz: float = 0.5, gait: str = "walk"
) -> TrialPart:  # fmt: skip
    """A side force that swings by ``size`` and a load, with noise of these sizes on them."""
    rng = np.random.default_rng(seed)
    time_s = np.linspace(0.0, 23.96, 600)
    swing = np.sin(2 * np.pi * hz * time_s)
    values = np.column_stack([
        size * swing + side * rng.standard_normal(600), 5.0 + load * rng.standard_normal(600)
    ])  # fmt: skip
    seen = Observation(
        time_s, hz * time_s, values, np.full(values.shape, 0.1), np.ones(values.shape)
    )
    return TrialPart(seed, 0, 600, gait, hz, seen)


REFERENCES = [run(seed) for seed in range(4)]


def vibration(*trials: TrialPart) -> ChannelVibration:
    seen = vibration_of(SHAKING, CHANNELS, trials, REFERENCES)
    assert seen is not None
    return seen


@pytest.mark.parametrize("times", [1.5, 2.0, 4.0])
def test_how_much_more_a_channel_vibrates_is_measured(times: float) -> None:
    seen = vibration(*(run(10 + i, side=0.1 * times) for i in range(4)))
    assert seen.excess == pytest.approx(2 * math.log(times), abs=0.15)
    assert "side vibrates " in seen.words


def test_a_channel_that_vibrates_speaks_for_what_shakes_it_and_one_at_rest_against_it() -> None:
    assert vibration(run(10, side=0.25)).nats > VIBRATION_CLEAR
    assert vibration(run(10, side=0.25)).chance < 0.01
    assert vibration(run(10)).nats < -2.0
    assert vibration(run(10)).chance > 0.2


def test_forces_that_are_larger_as_a_whole_do_not_count_as_vibration() -> None:
    assert abs(vibration(run(10, side=0.3, size=9.0)).excess) < 0.3


def test_what_shakes_the_whole_machine_is_not_held_for_what_shakes_one_channel() -> None:
    assert vibration(run(10, side=0.3, load=0.3)).nats < 0.0
    assert vibration(run(10, side=0.3, load=0.4)).nats < 0.0


def test_a_gait_that_no_reference_has_makes_it_less_sure() -> None:
    here, there = (vibration(run(10, side=0.25, gait=gait)) for gait in ("walk", "trot"))
    assert 0.0 < there.nats < 0.5 * here.nats


def test_references_at_the_same_frequency_are_what_is_compared_with() -> None:
    """Faster ones shake more: beside all together, a run that shakes would look as it should."""
    fast = [run(seed, side=0.4, hz=1.0) for seed in range(20, 24)]
    seen = vibration_of(SHAKING, CHANNELS, [run(10, side=0.25)], [*REFERENCES, *fast])
    assert seen is not None
    assert seen.excess == pytest.approx(2 * math.log(2.5), abs=0.25)


def test_nothing_is_said_where_nothing_was_measured_or_nothing_is_known() -> None:
    blind = run(10)
    values = blind.observation.values.copy()
    values[:, 0] = np.nan
    blind = replace(blind, observation=replace(blind.observation, values=values))
    assert vibration_of(SHAKING, CHANNELS, [blind], REFERENCES) is None
    assert vibration_of(SHAKING, CHANNELS, [run(10)], REFERENCES[:1]) is None
    assert vibration_of(SHAKING, CHANNELS, [run(10)], [blind, *REFERENCES[:1]]) is None


def answer(shaking: float, size: float = 1.3, references: int = 6) -> Diagnosis:
    trials = toy_case([Cause("speed_gain", (), (size,))], seed=4, shaking=shaking)
    return diagnose(trials, TOY, toy_references(4)[:references])


@pytest.mark.parametrize(("shaking", "named"), [(0.0, "speed_gain"), (3.0, "chatter")])
def test_of_two_effects_that_predict_the_same_vibration_decides(shaking: float, named: str) -> None:
    d = answer(shaking)
    assert d.verdict is Verdict.EXPLAINED
    (one,) = d.causes
    assert one.effect == named
    assert one.probability > 0.8
    assert one.cause.values[0] == pytest.approx(1.3, rel=0.05)
    told = next(rival for rival in d.rivals if rival.effect != named and rival.behind < 20.0)
    assert told.vibration_nats > 2.0
    assert one.vibration is not None
    assert any(
        "vibrate" in line for line in summary_lines(d, [Path(f"{i}.csv") for i in range(10)])
    )
    (found,) = diagnosis_json(d)["causes"]
    assert found["vibration"]["excess"] == one.vibration.excess


def test_without_references_both_stay_open() -> None:
    d = answer(3.0, references=0)
    assert d.verdict is Verdict.AMBIGUOUS
    assert {*(one.effect for one in d.causes), *(one.effect for one in d.ambiguous)} >= {
        "speed_gain",
        "chatter",
    }


def test_a_healthy_machine_has_no_gap_for_all_that() -> None:
    assert answer(0.0, size=1.0).verdict is Verdict.NO_GAP


def test_vibration_alone_is_nothing_that_the_effect_explains() -> None:
    assert not answer(3.0, size=1.0).causes


def test_what_surely_vibrates_is_surer_than_what_it_does_in_the_mean_and_its_size_is_rough() -> (
    None
):
    (steady,), (one,) = (answer(shaking, 1.02, references=3).causes for shaking in (0.0, 3.0))
    assert (steady.effect, one.effect) == ("speed_gain", "chatter")
    assert one.p < 0.1 * steady.p
    assert one.probability > 0.8
    # what a mean tells of a law is little, however well the mean is known
    assert steady.values[0].error < 0.02
    assert one.values[0].error >= 0.1 * MEAN_DIFFERS


def test_what_shakes_the_joints_is_not_held_for_feet_that_stick_and_slip() -> None:
    """Steps that a servo misses shake the forces as well."""
    channels = (*CHANNELS, Channel("shaft_error", "a", "", "rad"))
    shaking = replace(SHAKING, calm=(("load",), ("shaft_error",)))

    def with_shaft(part: TrialPart, shaft: float) -> TrialPart:
        rng, seen = np.random.default_rng(part.trial), part.observation
        more = shaft * rng.standard_normal(len(seen.time_s))
        values = np.column_stack([seen.values, more])
        wide = np.ones(values.shape)
        return replace(part, observation=replace(seen, values=values, noise=wide, weight=wide))

    references = [with_shaft(one, 0.01) for one in REFERENCES]
    still, shaken = (
        vibration_of(shaking, channels, [with_shaft(run(10, side=0.3), shaft)], references)
        for shaft in (0.01, 0.05)
    )
    assert still is not None
    assert shaken is not None
    assert still.nats > VIBRATION_CLEAR
    assert shaken.nats < 0.0
