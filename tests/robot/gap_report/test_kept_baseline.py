"""Baseline model errors are searched once for the same references, and again when anything changes."""

from pathlib import Path

import pytest

from gap.diagnosis.comparison.study import Study, make_study
from gap.interfaces import Cause
from record.trial.header import LEGGED, MJCF
from robot.gap_report import kept_baseline
from robot.gap_report.kept_baseline import baseline_of
from tests.gap.toy import Toy, toy_case, toy_references

CAUSES = (Cause("square_law", (), ()), Cause("offset", ("b",), (0.125,)))


def study(seed: int = 0) -> Study:
    return make_study(toy_case(), Toy(), toy_references(seed))


@pytest.fixture
def searched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Study]:
    """The studies whose references were searched, with a cache of their own."""
    calls: list[Study] = []

    def search(of: Study) -> tuple[Cause, ...]:
        calls.append(of)
        return CAUSES

    monkeypatch.setattr(kept_baseline, "commission", search)
    monkeypatch.setattr(kept_baseline, "_folder", lambda: tmp_path / "kept")
    return calls


def test_the_same_references_are_searched_once(searched: list[Study], tmp_path: Path) -> None:
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, False)
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, True)
    assert len(searched) == 1
    assert baseline_of(study(), LEGGED, fresh=True) == (CAUSES, False)
    assert len(searched) == 2
    assert [path.suffix for path in (tmp_path / "kept").iterdir()] == [".json"]


def test_other_references_and_another_program_are_searched_again(
    searched: list[Study], monkeypatch: pytest.MonkeyPatch
) -> None:
    baseline_of(study(), LEGGED, fresh=False)
    baseline_of(study(seed=1), LEGGED, fresh=False)
    assert len(searched) == 2
    monkeypatch.setattr(kept_baseline, "program_digest", lambda: "a later version")
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, False)


def test_nothing_is_kept_of_machines_whose_file_is_elsewhere(
    searched: list[Study], tmp_path: Path
) -> None:
    assert baseline_of(study(), MJCF, fresh=False) == (None, False)
    assert baseline_of(study(), "", fresh=False) == (None, False)
    few = make_study(toy_case(), Toy(), toy_references()[:1])
    assert baseline_of(few, LEGGED, fresh=False) == (None, False)
    assert not searched
    assert not (tmp_path / "kept").exists()


@pytest.mark.parametrize("damage", ["", "[", '{"a": 1}', '[{"effect": "lag"}]', "\0"])
def test_a_damaged_file_is_searched_again(
    searched: list[Study], tmp_path: Path, damage: str
) -> None:
    baseline_of(study(), LEGGED, fresh=False)
    (path,) = (tmp_path / "kept").iterdir()
    path.write_text(damage, encoding="utf-8")
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, False)
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, True)


def test_a_cache_that_cannot_be_written_is_none(
    searched: list[Study], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    monkeypatch.setattr(kept_baseline, "_folder", lambda: tmp_path / "file" / "kept")
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, False)
    assert baseline_of(study(), LEGGED, fresh=False) == (CAUSES, False)
