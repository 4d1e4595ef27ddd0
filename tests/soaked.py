"""Cases of which a few run in ``make test`` and the rest in ``make soak`` or ``make thorough``."""

from collections.abc import Callable, Iterable
from typing import TypeVar

import pytest
from _pytest.mark.structures import ParameterSet

Case = TypeVar("Case")


THOROUGH = pytest.mark.thorough


def soaked(
    cases: Iterable[Case],
    kept: Callable[[Case], bool],
    ids: Callable[[Case], str] = str,
    mark: pytest.MarkDecorator = pytest.mark.soak,
) -> list[ParameterSet]:
    """Return the parameters of a test; those that are not kept are marked."""
    return [pytest.param(case, id=ids(case), marks=() if kept(case) else mark) for case in cases]
