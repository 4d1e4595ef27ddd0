"""Where a gap is said to lie, and which values are said to lie on a bound."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.diagnosis.answer.verdict import fitted_values
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.comparison.where import FLIPS, cell_chances, where
from gap.interfaces import Cause, Drive, Effect, Parameter, Scope
from gap.residuals.phase_bins import PHASE_BINS
from gap.search.candidates import on_bound
from tests.gap.toy import Toy, toy_case, toy_references


@pytest.mark.parametrize("seconds", [16.0, 15.7])
def test_every_phase_is_looked_at_though_a_run_ends_within_a_cycle(seconds: float) -> None:
    trials = toy_case([Cause("stiffness", ("c",), (0.5,))], 3, seconds=seconds)
    study = make_study(trials, Toy(), toy_references(3))
    local = study.evidence(Drive.MEASURED)
    cells = where(local, study.evidence(Drive.COMMAND), local.base, 0).cells
    assert {(one.channel, one.joint) for one in cells} == {("force", "c")}
    phases = {one.phase for one in cells}
    assert len(phases) > PHASE_BINS // 2
    assert max(phases) > 0.5


def test_neutral_is_no_bound_even_where_it_lies_on_one() -> None:
    """Legs that flex fore and aft only have no sideways number; nothing is amiss with that."""
    numbers = [Parameter(name, "m/N", 0.0, 0.0, 1e-3, 1e-4) for name in ("along", "across")]
    effect = Effect("flex", "press", tuple(numbers), (Scope.ALL,), "It gives.", "Stiffen it.")
    for values, bounds in (
        ((1e-4, 0.0), [False, False]),
        ((1e-3, 1e-4), [True, False]),
        ((1e-4, 1e-12), [False, False]),
        ((5e-4, 1e-3), [False, True]),
    ):
        assert [on_bound(p, v) for p, v in zip(numbers, values, strict=True)] == bounds
        made = fitted_values(effect, Cause("flex", (), values), np.full(2, 0.1))
        assert [one.on_bound for one in made] == bounds


def test_a_range_without_end_has_no_wide_bounds() -> None:
    limit = Parameter("limit_rad_s", "rad/s", 1e9, 0.2, 1e9, 1.0)
    assert not on_bound(limit, 5.0)
    assert on_bound(limit, 0.2)


@given(st.integers(0, 1000), st.sampled_from([1 / 3, 0.1, 7.0, 1e-6]))
def test_rounding_does_not_change_chances_of_cells(seed: int, unit: float) -> None:
    values = 1.0 + 0.3 * np.random.default_rng(seed).normal(size=(6, 20))
    _, _, chance = cell_chances(values, seed)
    _, _, in_other_units = cell_chances(values * unit, seed)
    np.testing.assert_array_equal(chance, in_other_units)
    # signs that leave all alike are among those that are drawn, about two of 64, and all of them count
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(FLIPS, 6))
    alike = int((np.abs(signs.sum(axis=1)) == 6.0).sum())
    assert chance.min() >= (1 + alike) / (FLIPS + 1)
