"""Films of a run: of a log and of a trial, what is drawn in them, and words where none can be made."""

import importlib.util
import re
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from record.log.survey import survey_log
from record.trial.trial import read_trial, write_trial
from robot.cli.main import run as command
from robot.report.scene import LOADED, MEASURED, METRES_PER_NEWTON, Arrow, Body, Dot, LegScene
from robot.view.film_drawing import FilmDrawing
from robot.view.film_frame import FilmFrame


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


def test_clear_words_where_none_can_be_written(
    trial: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert command(["sim", "render", str(trial), "--out", "a.mp4"]) == 2
    told = capsys.readouterr().err
    assert (
        "an .mp4 needs imageio-ffmpeg (30 MB), which is not installed; install it with: pip" in told
    )
    assert "[video]" in told
    assert command(["show", "no.mcap", "--video", "a.mp4"]) == 2
    assert command(["sim", "render", str(trial), "--out", "a.bmp"]) == 2
    assert command(["sim", "render", "no.parquet", "--out", "a.png"]) == 4


@pytest.mark.parametrize(
    ("words", "code", "reason"),
    [
        (["--video", "a.avi"], 2, "--video: must end in .mp4 or .gif, not '.avi'"),
        (["--video", "nowhere/a.gif"], 4, "there is no folder nowhere"),
        (["--speed", "2"], 2, "are of a film; add --video FILE"),
        (["--video", "a.gif", "--fps", "0"], 2, "must be from 1 to 60"),
        (["--video", "a.gif", "--speed", "nan"], 2, "must be from 0.01"),
    ],
)
def test_wrong_words_for_a_film_are_answered_before_any_work(
    short_walk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    code: int,
    reason: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()  # of whoever made the walk
    try:
        ended = command(["show", str(short_walk), *words])
    except SystemExit as end:  # argparse's
        ended = int(end.code or 0)
    assert ended == code
    said = capsys.readouterr()
    assert reason in said.err
    assert not said.out
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("words_only")  # of the page beside it; test_cli.py has those
def test_a_log_becomes_a_film_of_its_length(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video, page = tmp_path / "walk.gif", tmp_path / "page.html"
    words = ["--video", str(video), "--out", str(page), "--speed", "4", "--fps", "4"]
    assert command(["show", str(short_walk), *words]) == 0
    pictures = _counted(capsys.readouterr().out, "4 times real time")
    assert pictures == pytest.approx(survey_log(short_walk).duration_s / 4 * 4, abs=2)
    with Image.open(video) as film:
        assert film.size == (640, 400)
        assert film.info["duration"] == 250
        assert 1 < getattr(film, "n_frames", 1) <= pictures, "equal pictures are one"


def test_a_trial_becomes_an_mp4(
    trial: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video = tmp_path / "walk.mp4"
    assert command(["sim", "render", str(trial), "--out", str(video), "--speed", "1"]) == 0
    pictures = _counted(capsys.readouterr().out, "real time")
    counted, seconds = imageio_ffmpeg.count_frames_and_secs(str(video))
    assert counted == pictures == 10
    assert seconds == pytest.approx(0.4, abs=0.1)


def _counted(told: str, pace: str) -> int:
    found = re.search(rf"(\d+) pictures, [\d.]+ s, {pace}", told)
    assert found, told
    return int(found[1])


def moment(loaded: bool, slip_m_s: float, force_n: float, x_m: float = 0.0) -> FilmFrame:
    foot = np.array([0.0, -0.3, -0.1])
    arrow = Arrow(foot, METRES_PER_NEWTON * np.array([0.0, 0.0, force_n]), MEASURED)
    leg = LegScene("FR", (), (Dot(foot, LOADED),), (arrow,) if force_n else ())
    return FilmFrame(
        time_s=x_m,
        position=np.array([x_m, 0.0, 0.1]),
        turn=Rotation.identity(),
        pose_from="ground truth",
        body=Body(np.zeros(3), np.array([0.5, 0.4, 0.05])),
        legs=(leg,),
        loaded=np.array([loaded]),
        slip_m_s=np.array([slip_m_s if loaded else np.nan]),
        words="walk",
    )


def coloured(picture: Image.Image, colour: tuple[float, ...]) -> int:
    """Pixels of a colour above the legend."""
    values = np.asarray(picture)[: int(0.75 * picture.height)].astype(int)
    return int((np.abs(values - np.asarray(colour)).max(axis=2) < 12).sum())


def test_a_picture_shows_force_and_slip() -> None:
    """A longer arrow for a larger force, and red where a loaded foot has slipped."""
    blue, red = tuple(255 * part for part in MEASURED), (214, 39, 40)

    def drawn(*frames: FilmFrame) -> Image.Image:
        drawing = FilmDrawing((640, 400), "a robot")
        for frame in frames:
            drawing.remember(frame)
        return drawing.picture(frames[-1])

    still, pressed, hard = (drawn(moment(True, 0.0, force)) for force in (0.0, 10.0, 30.0))
    assert coloured(still, blue) == 0
    assert 20 < coloured(pressed, blue) < coloured(hard, blue)
    slid = [moment(True, 0.05, 0.0, x) for x in np.linspace(0.0, 0.1, 20)]
    held = [moment(True, 0.0, 0.0, x) for x in np.linspace(0.0, 0.1, 20)]
    flew = [moment(False, 0.05, 0.0, x) for x in np.linspace(0.0, 0.1, 20)]
    assert coloured(drawn(*slid), red) > 50
    assert coloured(drawn(*held), red) == coloured(drawn(*flew), red) == 0


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
