"""``bigant gap effects``: the list for people and for programs, and wrong input."""

import json
from pathlib import Path

import pytest

from robot.cli import run


def test_the_list_names_every_effect_and_its_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects"]) == 0
    text = capsys.readouterr().out
    assert "ACTUATION\n  command_delay  (whole robot)\n      delay_s: 0 to 0.3 s, neutral 0" in text
    assert "39 effects" in text
    assert max(len(line) for line in text.splitlines()) <= 108


def test_json_has_units_bounds_and_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects", "--json", "--stage", "sensing"]) == 0
    effects = json.loads(capsys.readouterr().out)
    assert [e["effect"] for e in effects][:2] == ["force_gain", "force_bias"]
    assert effects[0]["scopes"] == ["leg"]
    assert effects[0]["parameters"][0]["name"] == "ratio"
    assert effects[0]["parameters"][0]["neutral"] == 1.0
    assert all(e["physics"] and e["remedy"] for e in effects)


def test_wrong_input_is_one_clear_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["gap", "effects", "--stage", "magic"]) != 0
    assert "stages are actuation, kinematics" in capsys.readouterr().err
    assert run(["gap", "effects", "--effects", str(tmp_path / "none.py")]) != 0
    err = capsys.readouterr().err
    assert "there is no file" in err
    assert len(err.strip().splitlines()) == 1
