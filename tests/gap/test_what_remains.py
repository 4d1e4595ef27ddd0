"""What remains at the joint of a named cause: most there says that the cause is not all."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.comparison.where import PhaseCell, Where, clearest_there
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from tests.gap.toy import Toy, toy_case, toy_references

CELL = PhaseCell("angle", "a", "motion", 0.5, 1.0, 0.0, 0.01)


def test_more_than_anywhere_else_at_its_own_joint_is_said() -> None:
    d = diagnose(toy_case([Cause("stiffness", ("b",), (0.7,))], 3), Toy(), toy_references(3))
    (cause,) = d.causes
    assert cause.joints == ("b",)
    assert not [words for words in d.warnings if "clearest" in words], "it is all there is"

    def said(here: float, elsewhere: float) -> list[str]:
        cells = (
            replace(CELL, joint="b", statistic=here),
            replace(CELL, joint="", statistic=elsewhere),
        )
        remaining: Where = replace(d.remaining, cells=cells)
        return list(clearest_there([("stiffness", ("b",))], remaining))

    (words,) = said(-20.0, 8.0)
    assert "clearest at b (angle, 20 standard errors)" in words
    assert "stiffness only resembles the true one" in words
    assert not said(9.0, 2.0)
    assert not said(20.0, -18.0)
    assert not list(clearest_there((), replace(d.remaining, cells=(CELL,))))


def test_a_cause_that_resembles_another_leaves_most_at_its_own_joint() -> None:
    """A bump is no effect of the catalogue: that of another size at every angle comes nearest."""
    whole = diagnose(toy_case([Cause("stiffness", ("b",), (0.7,))], 3), Toy(), toy_references(5))
    bump = toy_case([Cause("bump", ("b",), (0.8, 0.1))], 3)
    nearest = diagnose(bump, Toy(), toy_references(5))
    assert {one.joints for one in nearest.causes} == {("b",)}
    assert whole.fit.left_there < 0.4
    assert whole.fit.closed_acting > 0.95
    assert nearest.fit.left_there > 1.0
    assert nearest.fit.closed_acting < 0.9
    assert whole.none < 0.1 < nearest.none
    assert not [one for one in whole.warnings if "resemble" in one]
    (words,) = [one for one in nearest.warnings if "only resemble the true one; compare" in one]
    times = float(words.split("leaves ")[1].split()[0])
    assert times == pytest.approx(np.exp(nearest.fit.left_there / 2), abs=0.06)
