"""JSON that somebody damaged is a ``ValueError``, whichever way it is damaged."""

from pathlib import Path

import pytest

from record.json_text import parse_json, read_json


def nested(count: int) -> str:
    return "[" * count + "]" * count


def test_what_a_program_writes_is_read() -> None:
    assert parse_json('{"a": [1, 2.5, null, "\\ud83e\\udd16", {"b": []}]}') == {
        "a": [1, 2.5, None, "\U0001f916", {"b": []}]
    }
    assert parse_json(nested(50))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        nested(51),
        nested(100_000),
        '{"a":' * 100_000,
        '{"a":' * 60 + "1" + "}" * 60,
        "[" + "1" * 5000 + "]",
        '["\\ud83e"]',
        '{"\\udd16": 1}',
    ],
    ids=range(9),
)
def test_what_somebody_damaged_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # of every kind
        parse_json(text)


def test_a_file_that_is_no_text_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(b'["\x9b"]')
    with pytest.raises(OSError, match="not UTF-8"):
        read_json(path)
