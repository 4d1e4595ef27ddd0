"""Arrays that grow by rows."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from record.growing_array import GrowingArray


@given(st.lists(st.integers(0, 3000), min_size=1, max_size=8), st.data())
def test_what_was_added_is_there_in_order(sizes: list[int], data: st.DataObject) -> None:
    parts = [np.random.default_rng(at).normal(size=(n, 2, 3)) for at, n in enumerate(sizes)]
    grown = GrowingArray(parts[0])
    looks = []
    for at, part in enumerate(parts, start=1):
        grown.extend(part)
        if data.draw(st.booleans(), label="look"):
            looks.append((at, grown.array()))
    whole = np.concatenate(parts)
    np.testing.assert_array_equal(grown.array(), whole)
    assert len(grown) == len(whole)
    for at, seen in looks:  # and what was looked at before has not changed
        np.testing.assert_array_equal(seen, np.concatenate(parts[:at]))


def test_texts_may_get_longer_and_numbers_wider() -> None:
    texts = GrowingArray(np.array(["ok"]))
    for more in (["ok"], ["a longer one"], ["no"]):
        texts.extend(np.array(more))
    assert texts.array().tolist() == ["ok", "a longer one", "no"]
    numbers = GrowingArray(np.array([1]))
    numbers.extend(np.array([1, 2]))
    numbers.extend(np.array([0.5]))
    assert numbers.array().tolist() == [1.0, 2.0, 0.5]


def test_objects_are_kept() -> None:
    one, other = object(), object()
    grown = GrowingArray(np.array([one], dtype=object))
    grown.extend(np.array([one, other], dtype=object))
    rows = grown.array()
    assert rows[0] is one
    assert rows[1] is other
