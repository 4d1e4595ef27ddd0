"""``bigant campaign make --reality``: one campaign a reality, and what a reality cannot have."""

import json
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError, RecordError
from record.trial.trial import read_trial
from robot.campaign.plan import campaign_reality, draw_cases, read_scenario
from robot.campaign.run import campaign_jobs, run_job
from robot.cli.main import run as command
from sim_hw.realities.catalogue import REALITIES, USUAL, find_reality
from sim_hw.twin.catalog import EFFECTS
from tests.robot.scenarios import ONE, SCENARIO, write_scenario


def test_effects_that_a_reality_cannot_have_are_skipped_and_listed(tmp_path: Path) -> None:
    path = write_scenario(tmp_path, SCENARIO)
    usual, bare = (read_scenario(path, find_reality(name)) for name in ("usual", "pose_only"))
    assert not usual.skipped
    skipped = dict(bare.skipped)
    assert {name for name in usual.effects if name.startswith("force_")} < set(skipped)
    assert set(usual.effects) - set(bare.effects) == set(skipped) - {"marker_swap"}
    drawn = {one.name for case in draw_cases(bare, b"x") for one in case.effects}
    assert drawn.isdisjoint(skipped)
    named = write_scenario(tmp_path, ONE)  # force_bias by name: skipped as well, not refused
    assert read_scenario(named, find_reality("no_forces")).effects == ()


def test_so_many_single_cases_are_drawn_as_are_asked_for(tmp_path: Path) -> None:
    text = SCENARIO.replace("repeats = 1", "repeats = 1\nsingles = 5")
    some = draw_cases(read_scenario(write_scenario(tmp_path, text)), b"x")
    single = [case.effects[0].name for case in some if case.kind == "single"]
    assert len(single) == 5
    other = draw_cases(read_scenario(write_scenario(tmp_path, text)), b"y")
    assert single != [case.effects[0].name for case in other if case.kind == "single"]
    (tmp_path / "bad.toml").write_text(text.replace("singles = 5", "singles = -5"))
    with pytest.raises(ConfigError, match="singles"):
        read_scenario(tmp_path / "bad.toml")


def test_a_trial_says_what_the_lab_knows_and_not_what_is_wrong(tmp_path: Path) -> None:
    path = write_scenario(tmp_path, ONE)
    scenario = read_scenario(path, find_reality("small"))
    (job, *_) = (j for j in campaign_jobs(scenario, b"x", tmp_path / "out") if j.effects)
    assert run_job(job) is None
    trial = read_trial(job.out)
    assert trial.header.sample_rate_hz == 50.0
    assert "mass = 2.8" in trial.header.robot_text
    assert np.isfinite(trial.force_n).all()
    files = [p for p in (tmp_path / "out").rglob("*") if p.is_file() and p.suffix != ".parquet"]
    assert files
    assert not any("force_bias" in p.read_text() for p in files)


def test_the_command_makes_one_in_a_folder_of_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_scenario(
        tmp_path, ONE.replace("controls = 1", "controls = 0").replace("count = 1", "count = 0")
    )
    line = ["campaign", "make", str(path), "--out", str(tmp_path / "out"), "--jobs", "1", "--json"]
    assert command([*line, "--reality", "no_forces"]) == 0
    (summary,) = json.loads(capsys.readouterr().out)["realities"]
    assert summary["reality"] == "no_forces"
    assert summary["skipped"].keys() == {"force_bias"}
    assert summary["trials"] == 0, "its only cases cannot be in this reality"
    folder = tmp_path / "out" / "no_forces"
    assert campaign_reality(folder) == find_reality("no_forces")
    assert campaign_reality(tmp_path) == USUAL
    (folder / "reality.json").write_text("{}")
    with pytest.raises(RecordError, match=r"reality\.json names no reality"):
        campaign_reality(folder)


def test_an_unknown_reality_is_refused_with_the_known_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_scenario(tmp_path, ONE)
    line = ["campaign", "make", str(path), "--out", str(tmp_path / "out")]
    assert command([*line, "--reality", "wrkshop"]) != 0
    told = capsys.readouterr().err
    assert "did you mean workshop?" in told
    assert all(one.name in told for one in REALITIES)
    assert not (tmp_path / "out").exists()
    out = tmp_path / "x.parquet"
    line = ["sim", "run", "--fast", "--out", str(out), "--reality", "pose_only", "--effect"]
    assert command([*line, "force_gain@ML"]) != 0
    assert "force_gain cannot be in pose_only: it has no force sensors" in capsys.readouterr().err
    assert command(["sim", "run", "--fast", "--out", str(out), "--reality", "all"]) != 0
    assert "all is for bigant campaign make" in capsys.readouterr().err


def test_the_list_of_realities(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["sim", "realities"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == [one.name for one in REALITIES]
    assert command(["sim", "realities", "--json"]) == 0
    listed = {one["name"]: one for one in json.loads(capsys.readouterr().out)}
    assert listed["usual"]["without_effects"] == []
    known = {kind.name for kind in EFFECTS}
    assert {"force_gain", "marker_swap"} <= set(listed["pose_only"]["without_effects"]) < known
    assert listed["cascaded"]["loop"]["kind"] == "cascaded"
