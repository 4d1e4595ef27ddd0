"""What is new among healthy runs: scatter of days, unseen conditions, what references lack already."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.alternatives.probability import Fit, none_of_them
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.commissioning import commissioned_study, standing_of
from gap.diagnosis.diagnose import diagnose, diagnose_study
from gap.interfaces import Cause, Drive
from gap.residuals.healthy import healthy_runs
from gap.residuals.part_error import PartError
from gap.residuals.parts import RunCondition, whole_parts
from gap.search.candidates import starts_of
from gap.search.novelty import weights_of_runs
from model.effects.machine_scale import USUAL_SIZE
from model.effects.settings import settings_of
from model.effects.shafts import shafts
from tests.gap.test_selection import evidences
from tests.gap.toy import CHANNELS, CONDITIONS, Toy, toy_case, toy_references, toy_trial
from tests.gap.walks import cause, command_trial, machine, simulator

SCATTER = 0.03  # of each joint's stiffness, from run to run


@pytest.mark.parametrize(
    ("seeds", "least"),
    [
        pytest.param(range(40, 43), 3, id="3"),
        pytest.param(range(40, 46), 5, id="6", marks=pytest.mark.soak),
    ],
)
def test_what_differs_from_day_to_day_as_much_is_no_gap(seeds: range, least: int) -> None:
    """A run has its stiffness in all of its blocks, so blocks alone would call it new."""
    verdicts = []
    for seed in seeds:
        known = toy_references(seed, wander=SCATTER)
        verdicts.append(diagnose(toy_case(seed=seed, wander=SCATTER), Toy(), known).verdict)
    assert verdicts.count(Verdict.NO_GAP) >= least


def test_a_cause_beyond_the_scatter_of_days_is_still_found() -> None:
    soft = Cause("stiffness", ("c",), (0.75,))
    d = diagnose(toy_case([soft], seed=7, wander=SCATTER), Toy(), toy_references(7, wander=SCATTER))
    assert [(c.effect, c.joints) for c in d.causes] == [("stiffness", ("c",))]
    assert d.detection is not None
    assert d.detection.p_cause < 0.01


def test_a_law_that_healthy_runs_lack_stands_before_anything_new_is_sought() -> None:
    law = Cause("square_law", (), ())
    conditions = (*CONDITIONS, *CONDITIONS[:2])
    known = [toy_trial([law], hz, g, seed=90 + i) for i, (hz, g) in enumerate(conditions)]
    standing = standing_of(known, Toy())
    assert law in standing
    # with another law the same bias has another trace on the force
    soft = Cause("stiffness", ("a",), (0.8,))
    trials = toy_case([law, soft], seed=9)
    d = diagnose_study(commissioned_study(trials, Toy(), known, standing=standing))
    assert [(c.effect, c.joints) for c in d.causes] == [("stiffness", ("a",))]
    assert d.causes[0].values[0].value == pytest.approx(0.8, rel=0.02)
    assert d.standing == standing


def test_an_unseen_frequency_is_judged_by_references_of_other_frequencies() -> None:
    """References predict a frequency that none of them has worse than their own: the floor must know."""
    toy = Toy()
    runs = [
        toy_trial([Cause("lag", (), (0.05,))], hz, g, seed=i)
        for i, (hz, g) in enumerate(CONDITIONS)
    ]
    runs += [
        toy_trial([Cause("lag", (), (0.05,))], hz, g, seed=9 + i)
        for i, (hz, g) in enumerate(CONDITIONS)
    ]
    known = [
        PartError(part, part.observation.values - toy.predict(run, (), Drive.MEASURED))
        for run, part in zip(runs, whole_parts(toy, runs), strict=True)
    ]
    seen = healthy_runs(CHANNELS, known, [RunCondition("walk", 0.5)])
    unseen = healthy_runs(CHANNELS, known, [RunCondition("walk", 1.1)])
    angles = [i for i, c in enumerate(CHANNELS) if c.name == "angle"]

    def energy(runs: object) -> float:
        return float(np.mean([one.residual[:, angles].var() * one.whitener.unsure[angles].mean() ** 2
                              for one in runs]))  # type: ignore[attr-defined]  # fmt: skip

    assert all(np.isfinite(one.residual).all() for one in unseen)
    assert energy(unseen) > 1.5 * energy(seen)


def test_what_a_healthy_machine_leaves_as_well_is_no_sign_of_something_unknown() -> None:
    usual = Fit(0.4, excess_after=1.1, worst_after=1.5, p_after=0.5, nats_after=0.0)
    odd = replace(usual, p_after=1e-5)
    assert none_of_them(usual, 1, referenced=True) < 0.1
    assert none_of_them(odd, 1, referenced=True) > 0.5


def test_a_cause_of_a_roughly_known_form_may_leave_half_of_what_it_does() -> None:
    """Play, friction and give of a servo: no two machines have them in one form."""
    known = Fit(
        0.5, excess_after=1.5, worst_after=7.0, p_after=1e-5, nats_after=0.0, closed_acting=0.5
    )
    rough = replace(known, rough=1.0)
    assert none_of_them(known, 1, referenced=True) > 0.8
    assert none_of_them(rough, 1, referenced=True) < 0.05
    resembling = replace(rough, closed=0.05, closed_acting=0.05)
    assert none_of_them(resembling, 1, referenced=True) > 0.9, "it is something else"


def test_mass_that_is_pulled_along_may_leave_a_third_and_gusts_are_no_mass() -> None:
    """Right ones close 0.5 to 1 of the gap, mass in the place of gusts at most 0.34 (labels open)."""
    mass = Fit(0.58, 2.5, 6.0, p_after=1e-4, nats_after=0.0, closed_acting=0.56)
    assert none_of_them(mass, 1, referenced=True) > 0.5
    assert none_of_them(replace(mass, rough=0.6), 1, referenced=True) < 0.1
    gusts = Fit(0.34, 1.6, 5.0, p_after=1e-4, nats_after=0.0, closed_acting=0.56, rough=0.6)
    assert none_of_them(gusts, 1, referenced=True) > 0.5


def test_fits_begin_where_a_place_is_likely() -> None:
    """An edge may be as far as ten metres; runs of half a metre cross it near their start or not at all."""
    step = next(e for e in simulator().effects if e.name == "ground_step")
    places = [start[1] for start in starts_of(step, [False, True])]
    assert sum(-0.4 < x < 0.8 for x in places) >= 4


def test_two_lags_stand_one_behind_the_other() -> None:
    """A filter before a servo that lags itself is two filters: after a step of speed, w0 t - 2 T w0."""
    names = machine().names
    inputs = simulator()._inputs(command_trial("tripod", 0.2, 8.0))
    both = settings_of([cause("servo_lag", 0.05), cause("servo_lag", 0.05)], names, USUAL_SIZE)
    one = settings_of([cause("servo_lag", 0.1)], names, USUAL_SIZE)
    none = settings_of([], names, USUAL_SIZE)
    grid, command = inputs.grid, inputs.command_rad
    twice, once, plain = (shafts(grid, command, command, s, None) for s in (both, one, none))
    rest = np.abs(twice - once).max()
    assert rest > 1e-3  # not one filter with the sum of the constants
    speed = np.gradient(plain, inputs.grid.period_s, axis=0)
    steady = np.abs(np.gradient(speed, inputs.grid.period_s, axis=0)).max(axis=1) < 1e-6
    steady = (
        np.convolve(steady, np.ones(60), "full")[: len(steady)] > 59.5
    )  # for more than a second
    assert steady.any()
    assert np.allclose((plain - twice)[steady], 0.1 * speed[steady], atol=2e-4)


def test_a_reference_that_a_cause_helps_is_weighed_by_what_it_leaves_as_trials_are() -> None:
    """Else a cause that explains most and ignores the rest is large in trials, and small in references."""
    runs = evidences(Toy(), toy_case(seed=3), toy_references(3))[1]
    assert runs is not None
    healthy = runs.runs
    helped = (healthy.block_part == 1)[healthy.block_of_frame][:, None]
    base, changed = healthy.weights(healthy.base), np.where(helped, 0.1, 3.0) * healthy.base
    weights = weights_of_runs(healthy, changed)
    np.testing.assert_array_equal(weights, np.where(helped, healthy.weights(changed), base))
    assert (weights > base)[helped[:, 0]].any()
