"""One picture of a film, drawn without a display or graphics card: a camera that follows, and Pillow.

Everything is drawn at twice its size and halved, which smooths the edges.
"""

import math
from collections import deque
from collections.abc import Iterator
from itertools import groupby, pairwise

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from model.values.arrays import FloatArray
from robot.report.scene import (
    COUPLER,
    ESTIMATED,
    FULL_SLIP_M_S,
    LINK,
    LOADED,
    MEASURED,
    PREDICTED,
    SHOWN_SLIP_M_S,
    Colour,
)
from robot.view.film_frame import FilmFrame

Pixels = tuple[int, int, int]
# Time [s], place (3,) [m], and the colour of the way to it; None where the foot was lifted.
FootPath = deque[tuple[float, FloatArray, Pixels | None]]
FINER = 2
AZIMUTH_RAD, ELEVATION_RAD = math.radians(-58.0), math.radians(26.0)
RIGHT = np.array([-math.sin(AZIMUTH_RAD), math.cos(AZIMUTH_RAD), 0.0])
AWAY = -np.array([
    math.cos(AZIMUTH_RAD) * math.cos(ELEVATION_RAD),
    math.sin(AZIMUTH_RAD) * math.cos(ELEVATION_RAD),
    math.sin(ELEVATION_RAD),
])  # fmt: skip
UP = np.cross(RIGHT, AWAY)
DISTANCE_LENGTHS, FOCAL_SHARE = 2.6, 1.15  # of the camera: robot's lengths away; picture's widths
FOLLOW_S = 0.7
GRID_M, GRID_LINES = 0.1, 14
TRAIL_S, TRAIL_STEP_M = 12.0, 0.003
CHART_S = 10.0
SHADES = 8
FOOT_STEP_M = 0.001
PAPER: Pixels = (255, 255, 255)
GRID: Pixels = (226, 229, 234)
INK: Pixels = (33, 37, 41)
FAINT: Pixels = (110, 117, 125)
SHADOW: Pixels = (214, 218, 224)
TOP: Pixels = (196, 209, 224)
SIDES: tuple[Pixels, ...] = ((168, 184, 203), (150, 168, 190))
STUCK: Pixels = (120, 144, 168)
SLIPPING: Pixels = (214, 39, 40)


class FilmDrawing:
    """Draws frames one behind the other: paths and the chart are of what came before.

    Args:
        size: Width and height of a picture [pixels].
        title: What is shown, for the first line.
    """

    def __init__(self, size: tuple[int, int], title: str) -> None:
        self._size, self._title = size, title
        self._target: FloatArray | None = None
        self._span_m = 0.0
        self._last_s = 0.0
        self._body_path: deque[tuple[float, FloatArray]] = deque()
        self._foot_paths: list[FootPath] = []
        self._chart: deque[tuple[float, FloatArray]] = deque()
        unit = size[1] * FINER / 100
        self._unit = unit
        self._font = ImageFont.load_default(size=max(9.0 * FINER, 3.1 * unit))
        self._small = ImageFont.load_default(size=max(8.0 * FINER, 2.5 * unit))

    def remember(self, frame: FilmFrame) -> None:
        """Take a moment into paths and chart, whether it is drawn or not."""
        self._follow(frame)
        now, feet = frame.time_s, self._feet(frame)
        _extend(self._body_path, now, frame.position * [1.0, 1.0, 0.0])
        self._foot_paths = self._foot_paths or [deque() for _ in feet]
        for path, foot, loaded, slip in zip(
            self._foot_paths, feet, frame.loaded, frame.slip_m_s, strict=True
        ):
            if loaded and np.isfinite(foot).all():
                _step(path, now, foot * [1.0, 1.0, 0.0], slip_colour(float(np.nan_to_num(slip))))
            elif path and path[-1][2] is not None:
                path.append((now, path[-1][1], None))  # lifted: the path is broken here
            _forget(path, now - TRAIL_S)
        _forget(self._body_path, now - TRAIL_S * 10)
        shown = np.where(frame.loaded, np.nan_to_num(frame.slip_m_s), -1.0)
        self._chart.append((now, shown))
        _forget(self._chart, now - CHART_S)

    def _follow(self, frame: FilmFrame) -> None:
        if self._target is None:
            self._target = frame.position.copy()
            self._span_m = float(np.linalg.norm(frame.body.size[:2]))
        share = 1.0 - math.exp(-max(0.0, frame.time_s - self._last_s) / FOLLOW_S)
        self._target += share * (frame.position - self._target)
        self._last_s = frame.time_s

    @staticmethod
    def _feet(frame: FilmFrame) -> list[FloatArray]:
        """Feet in the world, (3,) each [m]; NaN where not known."""
        places = [leg.feet[0].place if leg.feet else np.full(3, np.nan) for leg in frame.legs]
        return [_world(frame, place) for place in places]

    def picture(self, frame: FilmFrame) -> Image.Image:
        """Return the picture of a moment that has been remembered."""
        width, height = (side * FINER for side in self._size)
        image = Image.new("RGB", (width, height), PAPER)
        draw = ImageDraw.Draw(image, "RGBA")
        self._floor(draw)
        self._paths(draw)
        self._robot(draw, frame)
        self._texts(draw, frame)
        self._slip_chart(draw, frame)
        return image.reduce(FINER)

    def _project(self, points: FloatArray) -> FloatArray:
        """Places in the world, (K, 3) [m], as pixels and distance, (K, 3)."""
        assert self._target is not None
        width, height = (side * FINER for side in self._size)
        seen = np.asarray(points) - self._target * [1.0, 1.0, 0.5]
        distance = DISTANCE_LENGTHS * self._span_m + seen @ AWAY
        scale = FOCAL_SHARE * min(width, 1.6 * height) / np.maximum(distance, 0.1 * self._span_m)
        x, y = width / 2 + scale * (seen @ RIGHT), 0.46 * height - scale * (seen @ UP)
        return np.stack([x, y, distance], axis=-1)

    def _line(
        self, draw: ImageDraw.ImageDraw, points: FloatArray, colour: tuple[int, ...], width: float
    ) -> None:
        flat = [(float(x), float(y)) for x, y, _ in self._project(points)]
        draw.line(flat, fill=colour, width=max(1, round(width * self._unit)), joint="curve")

    def _floor(self, draw: ImageDraw.ImageDraw) -> None:
        assert self._target is not None
        middle = np.round(self._target[:2] / GRID_M) * GRID_M
        reach = GRID_M * GRID_LINES / 2
        for step in np.arange(-GRID_LINES // 2, GRID_LINES // 2 + 1) * GRID_M:
            for across in (0, 1):
                ends = np.zeros((2, 3))
                ends[:, across] = middle[across] + step
                ends[:, 1 - across] = middle[1 - across] + [-reach, reach]
                self._line(draw, ends, GRID, 0.25)

    def _paths(self, draw: ImageDraw.ImageDraw) -> None:
        if len(self._body_path) > 1:
            points = np.array([place for _, place in self._body_path])
            self._line(draw, points, _pixels(ESTIMATED), 0.45)
        for path in self._foot_paths:
            for colour, places in _pieces(path):
                width = 0.7 if colour == STUCK else 1.1
                self._line(draw, places, colour, width)

    def _robot(self, draw: ImageDraw.ImageDraw, frame: FilmFrame) -> None:
        corners = frame.body.centre + frame.body.size * (_CORNERS - 0.5)
        box = np.array([_world(frame, corner) for corner in corners])
        base = self._project(box[[0, 2, 6, 4]] * [1.0, 1.0, 0.0])
        draw.polygon([(x, y) for x, y, _ in base.tolist()], fill=(*SHADOW, 160))
        items = [(float(self._project(box).mean(axis=0)[2]), -1)]
        for at, leg in enumerate(frame.legs):
            if leg.links:
                middle = _world(
                    frame, np.concatenate([one.points for one in leg.links]).mean(axis=0)
                )
                items.append((float(self._project(middle[None])[0, 2]), at))
        for _, at in sorted(items, reverse=True):
            if at < 0:
                self._box(draw, box)
            else:
                self._leg(draw, frame, at)
        for leg in frame.legs:
            for arrow in leg.forces:
                start = _world(frame, arrow.start)
                vector = frame.turn.apply(np.array(arrow.vector))
                width = 1.5 if arrow.colour == MEASURED else 0.7  # both are seen where they agree
                self._arrow(draw, start, vector, _pixels(arrow.colour), width)

    def _box(self, draw: ImageDraw.ImageDraw, box: FloatArray) -> None:
        places = self._project(box)
        faces = sorted(_FACES, key=lambda one: -float(places[list(one[0]), 2].mean()))
        for corners, colour in faces:
            outline = [(float(x), float(y)) for x, y, _ in places[list(corners)]]
            draw.polygon(outline, fill=(*colour, 120), outline=(*FAINT, 200))

    def _leg(self, draw: ImageDraw.ImageDraw, frame: FilmFrame, at: int) -> None:
        leg = frame.legs[at]
        for strip in leg.links:
            points = np.array([_world(frame, place) for place in strip.points])
            self._line(draw, points, _pixels(strip.colour), 0.9)
        for dot in leg.feet:
            (x, y, _), *_ = self._project(_world(frame, dot.place)[None]).tolist()
            r = 1.1 * self._unit
            colour = _pixels(LOADED) if frame.loaded[at] else (150, 150, 150)
            draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)

    def _arrow(
        self,
        draw: ImageDraw.ImageDraw,
        start: FloatArray,
        vector: FloatArray,
        colour: Pixels,
        width: float,
    ) -> None:
        tail, tip = self._project(np.stack([start, start + vector]))[:, :2]
        length = float(np.linalg.norm(tip - tail))
        head = min((1.6 + width) * self._unit, 0.6 * length)
        if length < 1.0:
            return
        along = (tip - tail) / length
        side = np.array([-along[1], along[0]])
        neck = tip - head * along
        draw.line([tuple(tail), tuple(neck)], fill=colour, width=max(1, round(width * self._unit)))
        wings = (tip, neck + 0.45 * head * side, neck - 0.45 * head * side)
        draw.polygon([(float(x), float(y)) for x, y in wings], fill=colour)

    def _texts(self, draw: ImageDraw.ImageDraw, frame: FilmFrame) -> None:
        unit, width = self._unit, self._size[0] * FINER
        draw.text((3 * unit, 2.5 * unit), self._title, INK, self._font)
        draw.text((3 * unit, 6.8 * unit), frame.words, FAINT, self._small)
        clock = f"{frame.time_s:.1f} s"
        draw.text((width - 3 * unit, 2.5 * unit), clock, INK, self._font, anchor="ra")
        pose = f"pose: {frame.pose_from}"
        draw.text((width - 3 * unit, 6.8 * unit), pose, FAINT, self._small, anchor="ra")

    def _slip_chart(self, draw: ImageDraw.ImageDraw, frame: FilmFrame) -> None:
        """A lane a leg: empty in the air, grey where the foot holds, red where it slips."""
        unit, (width, height) = self._unit, (side * FINER for side in self._size)
        lane = min(2.6 * unit, 0.2 * height / max(1, len(frame.legs)))
        left, right = 10 * unit, width - 3 * unit
        top = height - lane * len(frame.legs) - 2.5 * unit
        draw.rectangle((0, top - 5.0 * unit, width, height), fill=PAPER)
        self._legend(draw, top - 3.8 * unit)
        now = frame.time_s
        for at, leg in enumerate(frame.legs):
            y = top + lane * at
            draw.text((3 * unit, y + lane / 2), leg.name, FAINT, self._small, anchor="lm")
            draw.line([(left, y + lane / 2), (right, y + lane / 2)], fill=GRID, width=1)
            for begin_s, end_s, slip in _spans(self._chart, at):
                x0, x1 = (right - (right - left) * (now - t) / CHART_S for t in (begin_s, end_s))
                box = (max(x0, left), y + 0.14 * lane, x1, y + 0.86 * lane)
                draw.rectangle(box, fill=slip_colour(slip))

    def _legend(self, draw: ImageDraw.ImageDraw, y: float) -> None:
        x, unit = 3 * self._unit, self._unit
        for colour, words in (
            (_pixels(MEASURED), "force measured"),
            (_pixels(PREDICTED), "model"),
            (STUCK, "foot holds"),
            (SLIPPING, f"slips ({FULL_SLIP_M_S * 1e3:.0f} mm/s)"),
        ):
            draw.rectangle((x, y, x + 1.8 * unit, y + 1.8 * unit), fill=colour)
            draw.text((x + 2.6 * unit, y + 0.9 * unit), words, FAINT, self._small, anchor="lm")
            x += 5 * unit + draw.textlength(words, self._small)
        seconds = f"last {CHART_S:.0f} s"
        place = (self._size[0] * FINER - 3 * unit, y + 0.9 * unit)
        draw.text(place, seconds, FAINT, self._small, anchor="rm")


_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
_FACES = (
    ((1, 3, 7, 5), TOP), ((0, 2, 6, 4), SIDES[1]), ((0, 1, 5, 4), SIDES[0]),
    ((2, 3, 7, 6), SIDES[0]), ((0, 1, 3, 2), SIDES[1]), ((4, 5, 7, 6), SIDES[1]),
)  # fmt: skip


def film_colours() -> list[Pixels]:
    """Return the colours that pictures are made of, each also as it fades into the paper."""
    slips = [slip_colour(FULL_SLIP_M_S * at / 40) for at in range(41)]
    drawn = [
        *map(_pixels, (MEASURED, PREDICTED, ESTIMATED, LOADED, LINK, COUPLER)),
        *(GRID, INK, FAINT, SHADOW, TOP, *SIDES, STUCK), *dict.fromkeys(slips),
    ]  # fmt: skip
    faded = [
        tuple(round(own + share * (paper - own)) for own, paper in zip(one, PAPER, strict=True))
        for one in drawn
        for share in (0.0, 0.3, 0.6, 0.85)
    ]
    return [PAPER, *((r, g, b) for r, g, b in dict.fromkeys(faded))]


def slip_colour(slip_m_s: float) -> Pixels:
    """Return grey-blue for a foot that holds, red for one that slips, and what lies between."""
    share = min(1.0, max(0.0, slip_m_s - SHOWN_SLIP_M_S) / (FULL_SLIP_M_S - SHOWN_SLIP_M_S))
    share = round(SHADES * math.sqrt(share)) / SHADES
    r, g, b = (round(a + share * (z - a)) for a, z in zip(STUCK, SLIPPING, strict=True))
    return r, g, b


def _spans(
    chart: deque[tuple[float, FloatArray]], leg: int
) -> Iterator[tuple[float, float, float]]:
    """Begin, end [s] and slip [m/s] of the pieces of a lane: a foot is loaded, its colour the same."""
    piece: list[float] = []
    for time_s, slips in chart:
        slip = float(slips[leg])
        if piece and (slip < 0.0 or slip_colour(slip) != slip_colour(piece[2])):
            yield piece[0], time_s, piece[2]
            piece = []
        if slip >= 0.0:
            piece = piece or [time_s, time_s, slip]
            piece[1] = time_s
    if piece:
        yield piece[0], piece[1], piece[2]


def _step(path: FootPath, now: float, place: FloatArray, colour: Pixels) -> None:
    """Add a place of a foot on the ground, unless the last one is near and of the same colour."""
    if path and path[-1][2] == colour and np.linalg.norm(place - path[-1][1]) < FOOT_STEP_M:
        return
    path.append((now, place, colour))


def _pieces(path: FootPath) -> Iterator[tuple[Pixels, FloatArray]]:
    """Colour and places, (K, 3), of the pieces of a foot's path."""
    for colour, group in groupby(pairwise(path), key=lambda ends: ends[1][2]):
        ends = list(group)
        if colour is not None and ends[0][0][2] is not None:
            yield colour, np.array([ends[0][0][1], *(place for _, (_, place, _) in ends)])
        elif colour is not None and len(ends) > 1:  # behind a lift: not the way through the air
            yield colour, np.array([place for _, (_, place, _) in ends])


def _extend(path: deque[tuple[float, FloatArray]], now: float, place: FloatArray) -> None:
    if not path or np.linalg.norm(place - path[-1][1]) > TRAIL_STEP_M:
        path.append((now, place))


def _forget(
    path: "deque[tuple[float, FloatArray]] | FootPath",
    before_s: float,
) -> None:
    while path and path[0][0] < before_s:
        path.popleft()


def _world(frame: FilmFrame, place: FloatArray) -> FloatArray:
    """A place in the body frame, (3,), in the world."""
    there: FloatArray = frame.position + frame.turn.apply(np.array(place))
    return there


def _pixels(colour: Colour) -> Pixels:
    r, g, b = (round(255 * part) for part in colour)
    return r, g, b
