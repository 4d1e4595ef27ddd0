"""A quick dataclass is the dataclass that it was made from."""

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, replace
from inspect import signature

import pytest

from model.values.quick import quick


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
