"""Pictures and videos of a run: of a trial and of a log, and clear words where one cannot be made."""

import shutil
from pathlib import Path

import pytest
from PIL import Image

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
