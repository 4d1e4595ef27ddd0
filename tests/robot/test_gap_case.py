"""What the healthy runs of a campaign show is found once and kept."""

from pathlib import Path

import pytest

from gap.interfaces import Cause
from model.errors import RecordError
from robot.gap_case import Asked, commission_case

NOBODY = Asked((), (), (), Path("never.json"))


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
