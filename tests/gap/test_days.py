"""What days differ in is seen in references, and a new cause beside it is clearer than by itself."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.constants import FALSE_ALARMS, OPEN_LEVEL
from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.chances import clearer
from gap.search.beside_days import chance_beside_days, chance_beside_others
from gap.search.candidates import Candidate
from gap.search.days import SHARES, PulledRuns, _mean, day_variances, likeliest_day_share
from gap.search.fit import fit_causes
from gap.search.healthy_search import HealthySearch
from gap.search.run_fits import LaidRuns, fits_of, slices_of
from gap.search.screen import Signature, Signatures
from tests.gap.toy import JOINTS, LIKE, Toy, walked_day


def _drawn(deviations: tuple[float, ...], runs: int, seed: int) -> PulledRuns:
    """Runs in which changes have sizes of these standard deviations, about a mean that all have."""
    rng = np.random.default_rng(seed)
    changes = 40.0 * rng.standard_normal((len(deviations), 200)) / np.sqrt(200)
    sizes = 0.5 + np.array(deviations) * rng.standard_normal((runs, len(deviations)))
    measured = sizes @ changes + rng.standard_normal((runs, 200))
    return PulledRuns(measured @ changes.T, (0,) * runs, {0: changes @ changes.T})


def test_what_differs_from_day_to_day_is_told_from_what_does_not() -> None:
    runs = _drawn((0.2, 0.0, 0.0, 0.1, 0.0), 40, seed=1)
    variance = day_variances(runs, 0.03)
    assert variance[0] == pytest.approx(0.04, rel=0.6)
    assert variance[3] == pytest.approx(0.01, rel=0.6)
    assert (variance[[1, 2, 4]] < 0.002).all()


def test_the_share_that_all_parameters_differ_by_is_found() -> None:
    for share in SHARES[1:]:
        runs = _drawn((share,) * 8, 30, seed=2)
        assert likeliest_day_share(runs) == share


@pytest.mark.parametrize("least", [3.0, -60.0], ids=["definite", "indefinite by rounding"])
def test_the_inverse_of_each_part_is_that_of_its_products(least: float) -> None:
    turn = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
    gram, variance = turn @ np.diag([least, 8.0, 40.0]) @ turn.T, np.array([0.04, 0.03, 0.05])
    runs = PulledRuns(np.ones((1, 3)), (0,), {0: gram})
    _, inverse, logdet = _mean(runs, variance)
    whole = np.eye(3) + gram * variance
    np.testing.assert_allclose(inverse[0], np.linalg.inv(whole), rtol=1e-9, atol=1e-12)
    assert logdet[0] == pytest.approx(np.linalg.slogdet(whole)[1])


@given(st.floats(1e-250, 1.0), st.floats(1e-250, 1.0))
def test_of_two_chances_the_smaller_counts_at_most_half(alone: float, beside: float) -> None:
    least = min(alone, beside)
    both = clearer(alone, beside)
    if alone >= OPEN_LEVEL:
        assert both == alone
    else:
        assert least * (1 - 1e-9) <= both <= min(1.0, 2.0 * least) * (1 + 1e-9)
    assert clearer(alone, alone) == pytest.approx(alone)


def _comparison(wander: float, causes: tuple[Cause, ...] = (), seed: int = 7) -> GapEvidence:
    alike = (wander,) * len(JOINTS)
    trials = [walked_day(i, 1000 * seed + i, alike, causes) for i in range(4)]
    known = [walked_day(i, 1000 * seed + 500 + i, alike) for i in range(4)]
    return compare(make_study(trials, Toy(), known), lambda share: None)


def _search(comparison: GapEvidence) -> HealthySearch:
    assert comparison.known is not None
    return comparison.known.search


def test_a_candidate_beside_days_is_the_best_fit_in_which_days_cost_their_variance() -> None:
    """Against one augmented least-squares problem a run."""
    comparison = _comparison(0.05)
    search, matrix = _search(comparison), comparison.signatures.matrix.astype(np.float64)
    laid, cuts = search.with_trials, slices_of(comparison.evidence)
    variance = np.geomspace(1e-4, 1.0, len(laid.linear))
    fits = fits_of(laid, comparison.signatures, variance)
    for own, _ in itertools.islice(fits, 0, None, 5):
        signature = own.signature
        rows = list(signature.rows) if signature.offset < 0 else [signature.offset]
        others = [k for k, row in enumerate(laid.linear) if row not in rows]
        for run, part in enumerate(laid.runs.parts):
            block = matrix[:, cuts[part]]
            cost = np.diag(1.0 / np.sqrt(variance[others]))
            upper = np.vstack([block[rows], block[laid.linear[others]]]).T
            lower = np.hstack([np.zeros((len(others), len(rows))), cost])
            goal = np.concatenate([laid.residuals[run], np.zeros(len(others))])
            best = np.linalg.lstsq(np.vstack([upper, lower]), goal, rcond=None)[0][: len(rows)]
            assert np.linalg.solve(own.gram[run], own.pull[run]) == pytest.approx(
                best, rel=1e-2, abs=1e-4
            )


def _changes(likeness: float) -> Signatures:
    """Two changes of one part, so much alike, each of a candidate of its own."""
    rng = np.random.default_rng(4)
    first, second = rng.standard_normal((2, 400)) / 20.0
    first /= np.linalg.norm(first)
    second -= (second @ first) * first
    second = likeness * first + np.sqrt(1 - likeness**2) * second / np.linalg.norm(second)
    each = tuple(
        Signature(Candidate(effect, ()), (p.neutral,), (0,), (row,), -1)
        for row, effect in enumerate(one for one in Toy().effects if one.name in {"delay", "lag"})
        for p in effect.parameters
    )
    return Signatures(each, (60.0 * np.array([first, second])).astype(np.float32))


def test_beside_what_days_differ_in_a_change_that_is_like_it_scatters_less() -> None:
    """The first change differs by 0.3 between runs, and looks like the second in nine parts of ten."""
    signatures, rng = _changes(0.9), np.random.default_rng(5)
    days = 0.3 * rng.standard_normal(8)
    measured = days[:, None] * signatures.matrix[0] + rng.standard_normal((8, 400))
    gram = (signatures.matrix @ signatures.matrix.T).astype(np.float64)
    runs = PulledRuns(measured @ signatures.matrix.T, (0,) * 8, {0: gram})
    laid = LaidRuns(runs, np.arange(2), ("walk",) * 8, ())
    variance = day_variances(runs, 0.03)
    alone, beside = (
        next(own for own, _ in fits_of(laid, signatures, one) if own.signature.rows == (1,))
        for one in (None, variance)
    )
    scatter = [float(one.along(np.ones(1)).values.std()) for one in (alone, beside)]
    assert scatter[0] > 0.15
    assert scatter[1] < 0.3 * scatter[0]


def _of_a_lag(lag_s: float, other: Cause) -> tuple[float, float, float]:
    """Chances of a lag: as if alone, beside another cause, and if by itself it is like healthy runs."""
    lag = Cause("lag", (), (lag_s,))
    comparison = _comparison(0.02, (lag, other))
    evidence, search = comparison.evidence, _search(comparison)
    added = next(one for one in comparison.candidates if one.key == ("lag", ()))
    fitted = fit_causes(evidence, (other, lag))
    cause = fitted.causes[1]
    (left,) = evidence.residuals([fitted.causes[:1]])
    one = chance_beside_days(evidence, search, added, cause.values, left - fitted.residual)
    clear, usual = (
        chance_beside_others(evidence, search, added, cause, fitted, alone)
        for alone in (0.1 * FALSE_ALARMS, FALSE_ALARMS)
    )
    return one, clear, usual


def test_one_more_cause_is_clearer_beside_days_if_the_others_cannot_look_like_it() -> None:
    one, clear, usual = _of_a_lag(0.03, Cause("grip", ("a",), (1.5,)))
    assert one < 1e-3
    assert clear < 10.0 * one
    assert usual == 1.0  # by itself it is like what healthy runs show


def test_what_may_be_the_shape_of_a_large_cause_is_no_cause_beside_it() -> None:
    one, clear, _ = _of_a_lag(0.02, Cause("offset", ("a",), (4.0,)))
    assert one < 1e-2
    assert clear == 1.0


def test_only_references_that_are_matched_as_well_as_trials_are_show_what_a_chance_is_worth() -> (
    None
):
    trials = [walked_day(i, i, LIKE) for i in range(4)]

    def counted(references: int) -> int:
        known = [walked_day(i, 500 + i, LIKE) for i in range(references)]
        comparison = compare(make_study(trials, Toy(), known), lambda share: None)
        return len(_search(comparison).chances.each)

    assert counted(4) == 0  # every one has a condition of its own, which trials have not
    assert counted(6) == 4
    assert counted(8) == 8
