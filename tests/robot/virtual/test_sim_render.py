"""Pictures and videos of a run: of a trial and of a log, and clear words where one cannot be made."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from record.trial.trial import read_trial, write_trial
from robot.cli.main import run as command


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("render") / "a.parquet"
    assert command(["sim", "run", "--fast", "--seconds", "0.4", "--out", str(out)]) == 0
    return out


def test_a_picture_and_a_video_of_a_trial(trial: Path, tmp_path: Path) -> None:
    picture, video = tmp_path / "a.png", tmp_path / "a.gif"
    assert command(["sim", "render", str(trial), "--out", str(picture), "--at", "0.2"]) == 0
    with Image.open(picture) as image:
        assert min(image.size) > 400
        assert len(set(image.convert("L").resize((50, 50)).tobytes())) > 20, "something is drawn"
    assert command(["sim", "render", str(trial), "--out", str(video), "--speed", "1"]) == 0
    with Image.open(video) as film:
        assert getattr(film, "n_frames", 1) >= 3


def test_clear_words_where_there_is_no_renderer(
    trial: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    assert command(["sim", "render", str(trial), "--out", "a.mp4"]) == 2
    assert "needs ffmpeg" in capsys.readouterr().err
    assert command(["sim", "render", str(trial), "--out", "a.bmp"]) == 2
    assert command(["sim", "render", "no.parquet", "--out", "a.png"]) == 4


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("body_position_m", 1e300, "the body is 1e+300 m away"),
        ("body_position_m", -np.inf, "the body is inf m away"),
        ("body_angles_rad", 1e300, "the body is turned by 1e+300 rad"),
        ("foot_m", 1e300, "a foot is 1e+300 m from the body"),
        ("force_n", np.inf, "a foot carries inf N"),
    ],
)
def test_a_run_that_is_no_robots_is_one_line(
    trial: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    column: str,
    value: float,
    words: str,
) -> None:
    bad, out = tmp_path / "bad.parquet", tmp_path / "a.png"
    good = read_trial(trial)
    values = getattr(good, column).copy()
    values[3, 0] = value
    values[1] = np.nan
    write_trial(replace(good, **{column: values}), bad)
    capsys.readouterr()
    for out in (tmp_path / "a.png", tmp_path / "a.gif"):
        assert command(["sim", "render", str(bad), "--out", str(out)]) == 4
        said = capsys.readouterr().err.strip().splitlines()
        assert len(said) == 1, said
        assert f"cannot be drawn: at {good.time_s[3]:.2f} s {words}" in said[0]
        assert not out.exists()


def test_poses_that_are_missing_and_a_video_without_end(
    trial: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good, bad = read_trial(trial), tmp_path / "bad.parquet"
    write_trial(replace(good, body_position_m=good.body_position_m * np.nan), bad)
    capsys.readouterr()
    assert command(["sim", "render", str(bad), "--out", str(tmp_path / "a.png")]) == 4
    assert "holds no poses of body and feet" in capsys.readouterr().err
    late = good.time_s.copy()
    late[-1] += 1e7
    write_trial(replace(good, time_s=late), bad)
    assert command(["sim", "render", str(bad), "--out", str(tmp_path / "a.gif")]) == 2
    assert "at most 36000 can be drawn" in capsys.readouterr().err
