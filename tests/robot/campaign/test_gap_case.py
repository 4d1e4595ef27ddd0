"""What the healthy runs of a campaign show is found once and kept."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from gap.interfaces import Cause
from model.errors import GapError, RecordError
from robot.campaign.answers import answer_all
from robot.campaign.case import CaseRequest, commission_case

NOBODY = CaseRequest((), (), Path("never.json"))


def test_what_was_kept_is_taken_again(tmp_path: Path) -> None:
    kept = tmp_path / "standing.json"
    kept.write_text(
        '[{"effect": "servo_lag", "joints": ["ML"], "values": [0.05]}]', encoding="utf-8"
    )
    assert commission_case(NOBODY, kept) == (Cause("servo_lag", ("ML",), (0.05,)),)


def test_a_broken_file_is_refused_by_name(tmp_path: Path) -> None:
    kept = tmp_path / "standing.json"
    kept.write_text('[{"effect": "servo_lag"}]', encoding="utf-8")
    with pytest.raises(RecordError, match=r"standing.json.*delete it"):
        commission_case(NOBODY, kept)


def test_a_case_that_cannot_be_read_does_not_stop_the_others(tmp_path: Path) -> None:
    asked = [
        CaseRequest((tmp_path / f"{name}.parquet",), (), tmp_path / "answers" / f"{name}.json")
        for name in ("first", "second")
    ]
    with pytest.raises(
        GapError, match=r"2 of 2 cases got no answer .*first: .*second: .*goes on from there"
    ):
        answer_all(asked, ThreadPoolExecutor(1), "cases")
