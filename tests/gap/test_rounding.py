"""Values are rounded to the first digit of their error, and nothing is printed as minus zero."""

import math

import pytest

from gap.detectable import Detectable
from gap.rounding import count_words, fixed, percent_words, value_words


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (-0.000723, 0.004, "-0.001 +- 0.004"),
        (0.05321, 0.0069, "0.053 +- 0.007"),
        (-0.0001, 0.004, "0.000 +- 0.004"),
        (0.0123, 0.0096, "0.01 +- 0.01"),
        (127.0, 30.0, "130 +- 30"),
        (3.02e-5, 2e-6, "3.0e-05 +- 2e-06"),
        (3e-7, 2e-6, "0 +- 2e-06"),
        (0.03412, 3e-5, "0.03412 +- 0.00003"),
        (0.034125, 0.0, "0.0341"),
        (0.034125, math.nan, "0.0341"),
        (math.nan, 0.1, "-"),
    ],
)
def test_a_value_has_the_digits_that_its_error_leaves(
    value: float, error: float, words: str
) -> None:
    assert value_words(value, error) == words


def test_a_unit_stands_behind_both() -> None:
    assert value_words(0.0213, 0.0021, "rad") == "0.021 +- 0.002 rad"


def test_shares_and_zeros_have_no_minus() -> None:
    assert percent_words(-0.001) == "0%"
    assert percent_words(-0.12) == "-12%"
    assert percent_words(math.nan) == "-"
    assert fixed(-0.04, 1) == "0.0"


def test_a_size_is_at_values_within_the_range_of_its_parameter() -> None:
    def at(size: float, neutral: float, lower: float, upper: float) -> tuple[float, ...]:
        return Detectable("e", "p", size, "", neutral, lower, upper).values

    assert at(0.25, 1.0, 0.1, 3.0) == (0.75, 1.25)
    assert at(0.25, 0.0, 0.0, 3.0) == (0.25,)
    assert at(21.1, 0.0, -1.5, 1.5) == ()


def test_a_count_agrees_with_its_noun() -> None:
    assert [count_words(n, "hole") for n in (0, 1, 2)] == ["0 holes", "1 hole", "2 holes"]
