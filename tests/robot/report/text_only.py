"""Pages without their pictures, for tests that read only their words: drawing is most of a page's time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def without_pictures() -> Iterator[None]:
    """Leave the pictures out of every page; their figures are still made, and laid out by none."""
    from matplotlib.figure import Figure

    from robot.report import pictures

    def no_plots(figure: object) -> str:
        return "{}"

    def no_svg(figure: object, number: str) -> str:
        return "<svg/>"

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "moving_json", no_plots)
        patch.setattr(pictures, "inline_svg", no_svg)
        patch.setattr(Figure, "draw_without_rendering", lambda figure: None)
        yield


@pytest.fixture
def empty_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are files with nothing in them, for tests that read only their names."""
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "savefig", lambda _, path, **more: Path(path).touch())


@pytest.fixture
def words_only() -> Iterator[None]:
    """As ``without_pictures``, for a test."""
    with without_pictures():
        yield
