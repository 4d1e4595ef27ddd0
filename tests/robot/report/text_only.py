"""Pages without their pictures, for tests that read only their words: drawing is most of a page's time."""

import pytest
from matplotlib.figure import Figure

from robot.report import pictures


@pytest.fixture
def words_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures out of every page; their figures are still made."""

    def no_plots(figure: Figure) -> str:
        return "{}"

    def no_svg(figure: Figure, number: str) -> str:
        return "<svg/>"

    monkeypatch.setattr(pictures, "moving_json", no_plots)
    monkeypatch.setattr(pictures, "inline_svg", no_svg)
