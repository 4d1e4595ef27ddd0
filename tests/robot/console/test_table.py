"""Numbers and tables as text."""

import math

import pytest

from robot.console.table import Column, formed, markdown_lines, row_lines, table_lines

COLUMNS = (Column("leg"), Column("Fz N", ".2f"), Column("", ".0%", 6), Column("state"))


def test_columns_are_as_wide_as_what_is_in_them_and_numbers_stand_right() -> None:
    lines = table_lines(COLUMNS, [("HL", 1.25, 0.5, "fine"), ("MR", -12.5, None, "")], "  ")
    assert lines == [
        "  leg    Fz N          state",
        "  HL     1.25     50%  fine",
        "  MR   -12.50       -",
    ]


def test_a_table_without_names_has_no_heading() -> None:
    assert table_lines((Column(""), Column("", "d")), [("a", 1), ("bc", 20)]) == [
        "a    1",
        "bc  20",
    ]


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (-0.001, ".1f", "0.0"), (-0.001, ".0%", "0%"), (math.nan, ".1f", "-"), (None, "", "-"),
        (math.inf, "", "-"), (3, ".1f", "3.0"), ("N/m", ".1f", "N/m"), (-0.06, ".1f", "-0.1"),
    ],
)  # fmt: skip
def test_a_cell_is_a_dash_where_nothing_is_known_and_never_minus_zero(
    value: object, form: str, text: str
) -> None:
    assert formed(value, form) == text


def test_a_text_that_is_too_long_goes_on_below_itself() -> None:
    rows = [("loop", "one two three four five"), ("x", "")]
    assert row_lines(rows, 26) == ["loop  one two three four", "      five", "x     "]
    assert row_lines(rows) == ["loop  one two three four five", "x     "]


def test_a_table_of_a_page() -> None:
    assert markdown_lines(("a", "b"), [("1", "2")]) == ["| a | b |", "|---|---|", "| 1 | 2 |"]
