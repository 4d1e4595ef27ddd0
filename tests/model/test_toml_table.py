"""The strict table: every way a value can be wrong names its key."""

import math

import pytest

from model.errors import ConfigError
from model.parameters.toml_table import Table


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("1", "must be a number"),
        (True, "must be a number"),
        (math.nan, "must be finite"),
        (math.inf, "must be finite"),
        (0.0, "must be above 0"),
        (-1, "must be above 0"),
    ],
)
def test_bad_numbers_are_refused(value: object, words: str) -> None:
    with pytest.raises(ConfigError, match=words) as caught:
        Table({"mass": value}, "body").number("mass", above=0)
    assert caught.value.key == "body.mass"


def test_missing_key_is_named() -> None:
    with pytest.raises(ConfigError, match=r"body\.mass: is missing"):
        Table({}, "body").number("mass")


def test_unknown_key_is_named_with_a_suggestion() -> None:
    table = Table({"mass": 1.0, "mas": 2.0}, "body")
    table.number("mass")
    with pytest.raises(ConfigError, match=r"body\.mas: is not a known key; did you mean 'mass'\?"):
        table.done()


def test_wrong_length_is_named() -> None:
    with pytest.raises(
        ConfigError, match=r"legs\.id: must have 3 entries, one a leg or axis, not 2"
    ):
        Table({"id": [1, 2]}, "legs").integers("id", 3, minimum=0, maximum=9)


def test_wrong_shape_names_the_entry() -> None:
    with pytest.raises(ConfigError, match=r"a\.p\[1\]: must have 2 entries"):
        Table({"p": [[1, 2], [3]]}, "a").numbers("p", (2, 2))


def test_entry_out_of_range_is_named() -> None:
    with pytest.raises(ConfigError, match=r"a\.p\[1\]: must be above 0, not -1"):
        Table({"p": [1, -1.0]}, "a").numbers("p", (2,), above=0)


def test_arrays_are_read_only() -> None:
    array = Table({"p": [1, 2]}, "a").numbers("p", (2,))
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 3.0
