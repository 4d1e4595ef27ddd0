"""What remains at the joint of a named cause: clearest there says that the cause is not all."""

from dataclasses import replace

from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.where import PhaseCell, Where, clearest_there
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
