"""Values come back from bytes without a bit lost, and bytes make nothing but expected classes."""

import enum
import struct
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from model.values.arrays import FloatArray
from record.exact_values import classes_in, decode_values, encode_values


class Side(enum.Enum):
    LEFT = 1
    RIGHT = 2


class Pair(NamedTuple):
    one: float
    other: int


@dataclass(frozen=True, eq=False)
class Inner:
    numbers: FloatArray
    side: Side


@dataclass(frozen=True, eq=False)
class Outer:
    inner: tuple[Inner, ...]
    pair: Pair | None
    words: str
    flag: bool


def back(value: object) -> object:
    return decode_values(encode_values(value), classes_in(Outer), str.upper)


numbers = arrays.arrays(
    st.sampled_from([np.float64, np.int64, np.bool_]), arrays.array_shapes(min_dims=0, min_side=0)
)
inner = st.builds(Inner, numbers, st.sampled_from(Side))
outer = st.builds(
    Outer,
    st.lists(inner, max_size=3).map(tuple),
    st.none() | st.builds(Pair, st.floats(), st.integers(-(2**62), 2**62)),
    st.text(),
    st.booleans(),
)


@given(outer)
def test_a_value_comes_back_as_it_was(value: Outer) -> None:
    made = back(value)
    assert isinstance(made, Outer)
    assert encode_values(made) == encode_values(value)
    assert (made.words, made.flag) == (value.words, value.flag)
    for one, other in zip(made.inner, value.inner, strict=True):
        assert one.side is other.side
        assert one.numbers.dtype == other.numbers.dtype
        assert one.numbers.tobytes() == other.numbers.tobytes()
        assert not one.numbers.flags.writeable


def test_the_order_in_memory_and_the_kind_of_a_number_stay() -> None:
    turned = np.arange(6.0).reshape(2, 3).T
    made = back(Inner(turned, Side.LEFT))
    assert isinstance(made, Inner)
    assert made.numbers.flags.f_contiguous
    assert not made.numbers.flags.c_contiguous
    np.testing.assert_array_equal(made.numbers, turned)
    single = back(np.float64(0.1))
    assert type(single) is np.float64
    assert single == 0.1


def test_the_bytes_are_a_text_and_then_the_numbers() -> None:
    data = encode_values(Pair(0.5, 7))
    assert data == struct.pack("<I", len(b'["object","Pair",0.5,7]')) + b'["object","Pair",0.5,7]'
    data = encode_values(np.array([1.0, 2.0]))
    text = b'["array","<f8","C",false,2]'
    assert data == struct.pack("<I", len(text)) + text + struct.pack("<2d", 1.0, 2.0)


def test_a_name_stands_for_what_is_not_written() -> None:
    data = encode_values((1, "gait"), lambda v: "tripod" if v == "nothing" else None)
    assert decode_values(data, {}, str.upper) == (1, "gait")
    data = encode_values((Side.LEFT,), lambda v: "tripod" if v is Side.LEFT else None)
    assert decode_values(data, {}, str.upper) == ("TRIPOD",)


@pytest.mark.parametrize(
    "text",
    [
        b'["object","Popen","ls"]', b'["object","Outer"]', b'["member","Side","UP"]', b'["array"]',
        b'["array","O","C",false,1]', b'["array","<f8","C",false,-1]', b'["array","<f8","C",false,9]',
        b'["other","Side"]', b"[[1]]", b"{", b"",
    ],
)  # fmt: skip
def test_other_bytes_make_nothing(text: bytes) -> None:
    with pytest.raises(ValueError):
        decode_values(struct.pack("<I", len(text)) + text, classes_in(Outer), str.upper)


def test_what_has_no_bytes_is_refused() -> None:
    for value in (object(), [1], {"a": 1}, np.array([object()])):
        with pytest.raises(TypeError, match="no bytes"):
            encode_values(value)
