"""``bigant show --video`` and ``bigant sim render``: a run as a film, drawn off-screen."""

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path

from PIL import Image

from model.errors import ConfigError, RecordError
from record.log.reader import LogContents, read_stamped_ticks
from record.log.survey import survey_log
from record.whole_file import check_room, whole_file
from robot.config.robot_file import parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.progress import ProgressBar
from robot.requests.recorded import ShowRequest
from robot.requests.sim import SimRenderRequest
from robot.view.film_drawing import FilmDrawing
from robot.view.film_file import FILM_SUFFIXES, check_film, write_film
from robot.view.film_frame import FilmFrame, read_table, tick_frames, trial_frames
from robot.view.watch import ticks_with_true_forces

SIZES = {".mp4": (1280, 720), ".gif": (640, 400), ".png": (1280, 720)}
FPS = {".mp4": 25.0, ".gif": 12.5}
MOST_PICTURES = 36_000  # of a film: 24 minutes of it


def check_log_film(video: Path) -> None:
    """Refuse a film of a log that cannot be written, before anything is read.

    Raises:
        ConfigError: Its suffix is of no film, or what writes it is not installed.
        RecordError: There is no room for it.
    """
    check_room(video, "--video", *FILM_SUFFIXES)
    check_film(video, "--video")


def film_log(request: ShowRequest, video: Path) -> str:
    """Draw the film of a log; return what was made, in words.

    Raises:
        RecordError: The log cannot be read, or a file cannot be written.
        ConfigError: It would have too many pictures.
    """
    frames, span_s, title = _of_log(request.path)
    return _film(video, frames, span_s, title, Pace(request.speed, request.fps, video))


class Pace:
    """How fast a film runs: times real time, and pictures a second.

    Args:
        speed: None for real time.
        fps: None for what suits the file.
        out: The file.
    """

    def __init__(self, speed: float | None, fps: float | None, out: Path) -> None:
        self.speed = 1.0 if speed is None else speed
        self.fps = FPS[out.suffix] if fps is None else fps

    @property
    def words(self) -> str:
        """The speed in words."""
        return "real time" if self.speed == 1.0 else f"{self.speed:g} times real time"


def render(request: SimRenderRequest) -> ExitCode:
    """Draw one moment of a log or a trial, or a film of it.

    Raises:
        ConfigError: --out is of no kind that can be drawn here.
        RecordError: The run cannot be read, holds no poses, or some that are no robot's.
    """
    out = request.out
    if out.suffix not in {".png", *FILM_SUFFIXES}:
        raise ConfigError("--out", f"must end in .png, .gif or .mp4, not {out}")
    check_room(out, "--out")
    if out.suffix != ".png":
        check_film(out, "--out")
    trial = read_table(request.path)
    frames = trial_frames(trial, str(request.path))
    first_s, last_s = frames[0].time_s, frames[-1].time_s
    title = f"{trial.header.gait} at {trial.header.frequency_hz:g} Hz"
    if out.suffix != ".png":
        print(_film(out, frames, last_s - first_s, title, Pace(request.speed, None, out)))
        return ExitCode.OK
    at_s = request.at if request.at is not None else frames[len(frames) // 2].time_s
    if not first_s <= at_s <= last_s:
        raise ConfigError("--at", f"must be from {first_s:.2f} to {last_s:.2f} s, not {at_s:g}")
    drawing = FilmDrawing(SIZES[".png"], title)
    shown = min(frames, key=lambda one: abs(one.time_s - at_s))
    for one in frames[: frames.index(shown) + 1]:
        drawing.remember(one)
    with whole_file(out) as part:
        drawing.picture(shown).save(part, format="PNG")
    print(f"{out}: the robot at {shown.time_s:.2f} s")
    return ExitCode.OK


def _of_log(path: Path) -> tuple[Iterator[FilmFrame], float, str]:
    """Frames of a log, how long it is [s], and its title.

    Raises:
        RecordError: It holds no ticks, or no robot file to draw the robot from.
    """
    span_s = survey_log(path).duration_s
    contents = LogContents()
    ticks = ticks_with_true_forces(read_stamped_ticks(path, contents), contents)
    first = next(ticks, None)  # the robot file comes before the first tick
    if first is None:
        raise RecordError(f"{path} holds no ticks{': ' * bool(contents.damage)}{contents.damage}")
    try:
        parameters = parse_robot(contents.config_text).parameters
    except ConfigError as error:
        raise RecordError(
            f"{path} holds no robot file to draw the robot from ({error}); leave --video out"
        ) from error
    words = contents.metadata
    title = f"{words.get('robot', 'Robot')}: {words.get('gait', '')}".rstrip(": ")
    return tick_frames(chain((first,), ticks), parameters), span_s, title


def _film(out: Path, frames: Iterable[FilmFrame], span_s: float, title: str, pace: Pace) -> str:
    """Draw a film; return what was made, in words."""
    expected = span_s / pace.speed * pace.fps
    if expected > MOST_PICTURES:
        raise ConfigError(
            "--speed",
            f"{pace.speed:g} gives {expected:g} pictures; at most {MOST_PICTURES} can be drawn: choose a "
            "higher speed, or keep a part of the run with bigant log trim",
        )
    drawing = FilmDrawing(
        SIZES[out.suffix], f"{title}, {pace.words}" if pace.speed != 1.0 else title
    )
    with ProgressBar("drawing") as bar:

        def drawn() -> Iterator[Image.Image]:
            for at, frame in enumerate(_paced(drawing, frames, pace), start=1):
                yield drawing.picture(frame)
                bar.show(min(1.0, at / max(1.0, expected)), f"{at} pictures")

        count = write_film(out, drawn(), pace.fps)
    return f"{out}: {count} pictures, {count / pace.fps:.1f} s, {pace.words}"


def _paced(drawing: FilmDrawing, frames: Iterable[FilmFrame], pace: Pace) -> Iterator[FilmFrame]:
    """Let the drawing see all of a run, and yield the moments of which a picture is due."""
    next_s: float | None = None
    for frame in frames:
        drawing.remember(frame)
        if next_s is None or frame.time_s >= next_s:
            next_s = (frame.time_s if next_s is None else next_s) + pace.speed / pace.fps
            yield frame
