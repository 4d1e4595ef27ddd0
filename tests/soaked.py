"""Cases of which a few run in ``make test`` and the rest in ``make soak``."""

from collections.abc import Callable, Iterable
from typing import TypeVar

import pytest
from _pytest.mark.structures import ParameterSet

Case = TypeVar("Case")


def soaked(
    cases: Iterable[Case], kept: Callable[[Case], bool], ids: Callable[[Case], str] = str
) -> list[ParameterSet]:
    """Return the parameters of a test; those that are not kept are marked ``soak``."""
    return [
        pytest.param(case, id=ids(case), marks=() if kept(case) else pytest.mark.soak)
        for case in cases
    ]
