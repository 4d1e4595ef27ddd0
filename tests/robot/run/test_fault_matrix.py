"""Every fault of the catalogue on the whole loop: what is expected, and what the documentation says."""

import pytest

from benchmarks.faults import matrix
from benchmarks.faults.cases import CASES, TOGETHER, Case, assumed
from benchmarks.faults.matrix import (
    COUNTED,
    STREAM_COUNTED,
    Row,
    committed,
    driver_words,
    matrix_page,
    run_case,
)
from model.values.faults import FaultKind, StopReason
from sim_hw.faults.kinds import KINDS

# A stop that needs no settling on all feet is over within so long of its cause.
SOON_S = {StopReason.LINK_LOST: 0.05, StopReason.SERVO_LOST: 2.5, StopReason.SERVO_FAULT: 2.5}


# Faults of the page come at 5.5 s, in the first steps; at the pace of tests these are so much earlier.
FAULT_S = 1.5
# A cycle takes 3.3 s, near the shortest that the servos can, instead of 4.
FREQUENCY_HZ = 0.3


@pytest.fixture(autouse=True)
def early_faults(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(matrix, "FAULT_S", FAULT_S)
    monkeypatch.setattr(matrix, "WALK_S", matrix.WALK_S * matrix.FREQUENCY_HZ / FREQUENCY_HZ)
    monkeypatch.setattr(matrix, "FREQUENCY_HZ", FREQUENCY_HZ)
    monkeypatch.setattr(matrix, "CYCLE_S", 1 / FREQUENCY_HZ)


def names(case: Case) -> str:
    return f"{case.kind}: {case.what}"


def test_every_kind_is_in_the_matrix() -> None:
    assert {case.kind for case in CASES} == set(KINDS)


def test_the_page_counts_cases_and_kinds() -> None:
    assert f"{len(CASES)} scripted cases of {len(KINDS)} kinds" in matrix_page(committed())


def test_one_of_a_kind_is_no_plural() -> None:
    moved = {STREAM_COUNTED["restarts"]: 1, STREAM_COUNTED["missing"]: 26, COUNTED["timeouts"]: 0}
    assert driver_words(moved) == "1 restart of the stream, 26 samples missing"


FIRST = {case.kind: case for case in reversed(CASES)}  # of each kind
# To the loop each is as another one: no answer, a wrong checksum, an answer or samples too many or too few.
# What drivers and devices make of them: tests/sim_hw/test_servo_faults.py, test_wnet_faults.py.
ALIKE = {
    "truncated_request", "damaged_request", "late_request", "truncated_reply", "duplicated_reply",
    "duplicate_packet", "reordered_packet", "batching",
}  # fmt: skip


def kept(case: Case) -> bool:
    """The others run in soak, where all of them do."""
    return FIRST[case.kind] is case and case.kind not in ALIKE


def test_kinds_that_are_alike_are_kinds() -> None:
    assert set(KINDS) > ALIKE


@pytest.mark.parametrize(
    "case", [pytest.param(case, id=names(case)) for case in CASES if kept(case)]
)
def test_the_robot_does_what_it_should_and_the_page_says_so(case: Case) -> None:
    """Without the estimator, which decides nothing and is half of the time."""
    _check(case, run_case(case, estimate=False))


@pytest.mark.soak
@pytest.mark.parametrize("case", CASES, ids=names)
def test_with_the_estimator_it_does_so_too(case: Case) -> None:
    _check(case, run_case(case))


def _check(case: Case, row: Row) -> None:
    assert row.begun is not bool(case.refused)
    if case.refused:
        assert case.refused in row.words
    else:
        assert row.reason is case.reason, row.words
        assert case.reported <= {FaultKind[name] for name in row.reported}
        assert row.left_behind == (), "it walks on without a leg"
        _check_stop(row)
    cells = committed()[CASES.index(case)]
    assert (cells[0], cells[1], cells[3], cells[4]) == row.decisions, "make reliability"


def _check_stop(row: Row) -> None:
    if row.reason is StopReason.COMPLETED:
        return
    assert row.words, "every stop has a cause in words"
    assert row.path[-1] == ("LIMP" if row.reason is StopReason.LINK_LOST else "HOLD")
    assert row.safe_s < SOON_S.get(row.reason, 15.0)


# Each assumption with others, so that each meets each fault that a robot recovers from.
OTHER_ASSUMPTIONS = [
    pytest.param(case, together, id=f"{case.kind}, {number}")
    for case in CASES
    if case.recovery
    for number, together in enumerate(TOGETHER)
]


@pytest.mark.soak
@pytest.mark.parametrize(("case", "together"), OTHER_ASSUMPTIONS)
def test_under_other_assumptions_it_walks_on_with_all_legs_or_stands(
    case: Case, together: tuple[str, ...]
) -> None:
    row = run_case(case, assumed(together))
    assert row.begun
    assert row.left_behind == (), "it walks on without a leg"
    if row.reason is not case.reason:
        _check_stop(row)
        assert row.reason is not StopReason.COMPLETED
