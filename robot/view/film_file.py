"""Films and pictures as files: .mp4 by the ffmpeg that imageio-ffmpeg brings, .gif and .png by Pillow."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from model.errors import ConfigError, RecordError
from record.whole_file import whole_file
from robot.console.installed import how_to_install
from robot.view.film_drawing import film_colours

FILM_SUFFIXES = (".mp4", ".gif")
PACKAGE, EXTRA = "imageio_ffmpeg", "video"
MOST_COLOURS = 256  # of a .gif
GIF_UNIT_MS = 10  # in which a .gif counts


def check_film(out: Path, option: str) -> None:
    """Refuse a film that cannot be written, before anything is read.

    Raises:
        ConfigError: Its suffix is of no film, or what writes it is not installed.
    """
    if out.suffix not in FILM_SUFFIXES:
        raise ConfigError(option, f"must end in .mp4 or .gif, not {out.suffix or out.name!r}")
    if out.suffix == ".mp4" and importlib.util.find_spec(PACKAGE) is None:
        raise ConfigError(
            option,
            f"an .mp4 needs imageio-ffmpeg (30 MB), which is not installed; install it with: "
            f"{how_to_install(EXTRA)}, or choose .gif",
        )


def write_film(out: Path, pictures: Iterator[Image.Image], fps: float) -> int:
    """Write pictures as a film; return how many there were.

    Args:
        out: .mp4 or .gif.
        pictures: All of one size.
        fps: Pictures a second; a .gif has the nearest that its clock can show.

    Raises:
        RecordError: There is no picture, or the file cannot be written.
    """
    first = next(pictures, None)
    if first is None:
        raise RecordError("there is nothing to draw: no tick says where the robot is")
    counted = Counted(first, pictures)
    with whole_file(out) as part:
        if out.suffix == ".gif":
            _write_gif(part, counted, fps)
        else:
            _write_mp4(part, counted, fps)
    return counted.count


class Counted:
    """Pictures, the first of which is known, and how many have been taken."""

    def __init__(self, first: Image.Image, others: Iterator[Image.Image]) -> None:
        self.first, self.count = first, 0
        self._others = others

    def __iter__(self) -> Iterator[Image.Image]:
        self.count = 1
        yield self.first
        for one in self._others:
            self.count += 1
            yield one


def _write_gif(part: Path, pictures: Counted, fps: float) -> None:
    # one table of colours for all, without dithering: what stands still costs nothing then
    palette = Image.new("P", (1, 1))
    palette.putpalette([part for colour in film_colours()[:MOST_COLOURS] for part in colour])

    def small() -> Iterator[Image.Image]:
        for one in pictures:
            yield one.quantize(palette=palette, dither=Image.Dither.NONE)

    film = small()
    period_ms = max(2, round(1000 / fps / GIF_UNIT_MS)) * GIF_UNIT_MS
    next(film).save(
        part, format="GIF", save_all=True, append_images=film, duration=period_ms, loop=0
    )


def _write_mp4(part: Path, pictures: Counted, fps: float) -> None:
    from imageio_ffmpeg import write_frames  # an extra

    # H.264 in the colours that every player and every slide knows; sizes are even (film.py)
    film = write_frames(
        str(part), pictures.first.size, fps=fps, macro_block_size=2, quality=6,
        ffmpeg_log_level="error", output_params=["-movflags", "+faststart"],
    )  # fmt: skip
    film.send(None)
    try:
        for one in pictures:
            film.send(np.ascontiguousarray(np.asarray(one)))
    finally:
        film.close()
