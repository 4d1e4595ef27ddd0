"""A quick dataclass is the dataclass that it was made from."""

import pickle
from copy import copy
from dataclasses import FrozenInstanceError, astuple, dataclass, field, fields, replace
from inspect import signature

import pytest

from model.values.quick import MANY_FIELDS, quick


@dataclass(frozen=True, slots=True)
class Plain:
    """As ``dataclass`` makes it."""

    first: int
    second: str = "two"
    third: tuple[int, ...] = ()


@quick
@dataclass(frozen=True, slots=True)
class Quick:
    """The same, made quickly."""

    first: int
    second: str = "two"
    third: tuple[int, ...] = ()


def test_it_takes_the_same_arguments_and_stays_frozen() -> None:
    assert signature(Quick) == signature(Plain)
    one = Quick(1, third=(3,))
    assert (one.first, one.second, one.third) == (1, "two", (3,))
    assert one == Quick(1, "two", (3,)) != Quick(2)
    assert replace(one, first=5) == Quick(5, "two", (3,))
    assert pickle.loads(pickle.dumps(one)) == one
    with pytest.raises(FrozenInstanceError):
        one.first = 2  # type: ignore[misc]
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'first'"):
        Quick()  # type: ignore[call-arg]


@dataclass(frozen=True, slots=True)
class PlainMany:
    """As many fields as are stored in another way."""

    first: int
    second: str
    third: float
    fourth: bytes = b""
    fifth: tuple[int, ...] = ()


@quick
@dataclass(frozen=True, slots=True)
class Many:
    """The same, made quickly."""

    first: int
    second: str
    third: float
    fourth: bytes = b""
    fifth: tuple[int, ...] = ()


def test_one_with_many_fields_is_of_its_class_and_stays_frozen() -> None:
    assert len(fields(Many)) >= MANY_FIELDS
    assert signature(Many) == signature(PlainMany)
    one, plain = Many(1, "two", 3.0, fifth=(5,)), PlainMany(1, "two", 3.0, fifth=(5,))
    assert type(one) is Many
    assert isinstance(one, Many)
    assert astuple(one) == astuple(plain)
    assert repr(one) == repr(plain).replace("PlainMany", "Many")
    assert replace(one, first=5) == Many(5, "two", 3.0, fifth=(5,)) != one
    assert pickle.loads(pickle.dumps(one)) == copy(one) == one
    assert hash(one) == hash(copy(one))
    with pytest.raises(FrozenInstanceError):
        one.third = 2.0  # type: ignore[misc]
    with pytest.raises(AttributeError):
        object.__setattr__(one, "sixth", 6)


def test_what_does_more_than_store_its_fields_is_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Made:
        items: list[int] = field(default_factory=list)

    @dataclass(frozen=True, slots=True)
    class Checked:
        number: int

        def __post_init__(self) -> None:
            raise ValueError

    for kind in (Made, Checked):
        with pytest.raises(TypeError, match="does more in its __init__"):
            quick(kind)
