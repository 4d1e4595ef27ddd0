"""A log as a recording for Rerun, which needs no account and no network (extra ``bigant[rerun]``).

The file holds its own layout: the robot and its path on the left, velocities, forces, estimate and servos
on the right. ``rerun FILE.rrd`` opens it. A run that goes on is shown by ``robot.view.foxglove``.
"""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from matplotlib.colors import to_rgb

from model.values.arrays import FloatArray
from model.values.parameters import RobotParameters
from model.values.tick import Tick
from record.whole_file import clear_name, writing
from robot.report.figure_style import leg_colour
from robot.report.scene import ESTIMATED, MEASURED, PREDICTED, Colour, LegScene, body_of, legs_of
from robot.view.frames import BODY_FRAME, MAP_FRAME, ODOM_FRAME, TRUE_FRAME
from robot.view.numbers import known, numbers_of
from robot.view.viewer import Viewer

TIMELINE = "run"
LINK_M, FOOT_M, ARROW_M, PATH_M = 0.003, 0.009, 0.003, 0.002
# Where each frame lies in the tree; REP-105 as in the log.
PLACES = {
    MAP_FRAME: MAP_FRAME,
    ODOM_FRAME: f"{MAP_FRAME}/{ODOM_FRAME}",
    BODY_FRAME: f"{MAP_FRAME}/{ODOM_FRAME}/{BODY_FRAME}",
    TRUE_FRAME: f"{MAP_FRAME}/{TRUE_FRAME}",
}
BODY = PLACES[BODY_FRAME]
SERIES = {
    "true": MEASURED,
    "measured": MEASURED,
    "predicted": PREDICTED,
    "estimated": ESTIMATED,
}


class RerunView(Viewer):
    """Writes ticks into a recording.

    Args:
        parameters: Dimensions of the robot.
        save: File to write, ``.rrd``.

    Raises:
        RecordError: The file cannot be written.
    """

    def __init__(self, parameters: RobotParameters, save: Path) -> None:
        super().__init__(parameters)
        self._first_ns: int | None = None
        self._times_s: list[float] = []
        self._columns: dict[str, list[float]] = {}
        self._stream = rr.RecordingStream("bigant")
        clear_name(save, "--save")
        with writing(save, "--save"):
            save.open("wb").close()  # its own error would be a panic of another language
            try:
                self._stream.save(save, default_blueprint=layout(self.names.legs))
            except RuntimeError as error:
                raise OSError(str(error)) from error
        self._draw_what_stays()

    def _draw_what_stays(self) -> None:
        body = body_of(self.parameters)
        self._stream.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for place, colour, alpha in (
            (BODY, PREDICTED, 0.8),
            (PLACES[TRUE_FRAME], MEASURED, 0.3),
        ):
            box = rr.Boxes3D(
                sizes=[body.size], centers=[body.centre], colors=[_rgba(colour, alpha)]
            )
            self._stream.log(f"{place}/body", box, static=True)

    def note(self, tick: Tick, unix_ns: int) -> None:
        """Write what is new in a tick; see ``Viewer``."""
        for news in self.news.news_of(tick):
            self._go_to(unix_ns)
            level = "ERROR" if news.fault else "INFO"
            self._stream.log("news", rr.TextLog(f"{news.source} {news.text}", level=level))

    def show(self, tick: Tick, unix_ns: int) -> None:
        """Write frames, scene and numbers of a tick."""
        self._go_to(unix_ns)
        for transform in self.frames.transforms(tick):
            self._stream.log(
                PLACES[transform.child],
                rr.Transform3D(
                    translation=transform.translation,
                    quaternion=rr.Quaternion(xyzw=transform.rotation_xyzw),
                ),
            )
        self._draw_legs(legs_of(tick, self.parameters))
        if self.trajectory_due(unix_ns):
            for name, frame, points, colour in self.frames.trajectories():
                if len(points) > 1:
                    strip = rr.LineStrips3D(
                        [np.array(points)], radii=PATH_M, colors=[_rgba(colour)]
                    )
                    place = f"{PLACES[frame]}/way/{name.replace(' ', '_')}"
                    self._stream.log(place, strip)
        self._keep_numbers(tick, unix_ns)

    def _go_to(self, unix_ns: int) -> None:
        self._first_ns = unix_ns if self._first_ns is None else self._first_ns
        self._stream.set_time(TIMELINE, duration=(unix_ns - self._first_ns) * 1e-9)

    def _draw_legs(self, legs: tuple[LegScene, ...]) -> None:
        links = [strip for leg in legs for strip in leg.links]
        feet = [dot for leg in legs for dot in leg.feet]
        self._stream.log(
            f"{BODY}/links",
            rr.LineStrips3D(
                [strip.points for strip in links],
                radii=LINK_M,
                colors=[_rgba(strip.colour) for strip in links],
            ),
        )
        self._stream.log(
            f"{BODY}/feet",
            rr.Points3D(
                [dot.place for dot in feet],
                radii=FOOT_M,
                colors=[_rgba(dot.colour) for dot in feet],
            ),
        )
        for name, colour in (("measured", MEASURED), ("predicted", PREDICTED)):
            arrows = [arrow for leg in legs for arrow in leg.forces if arrow.colour == colour]
            self._stream.log(
                f"{BODY}/forces/{name}",
                rr.Arrows3D(
                    origins=_rows([arrow.start for arrow in arrows]),
                    vectors=_rows([arrow.vector for arrow in arrows]),
                    radii=ARROW_M,
                    colors=[_rgba(colour)],
                ),
            )

    def _keep_numbers(self, tick: Tick, unix_ns: int) -> None:
        """Numbers go out as whole columns in the end, which is a hundred times cheaper than one by one."""
        before = len(self._times_s)
        self._times_s.append((unix_ns - (self._first_ns or 0)) * 1e-9)
        for topic, numbers in numbers_of(tick, self.names):
            for name, value in known(numbers).items():
                if not isinstance(value, str):
                    group, _, field = name.rpartition(".")
                    path = "/".join(filter(None, ("plots" + topic, field, group)))
                    self._columns.setdefault(path, [np.nan] * before).append(value)
        for column in self._columns.values():
            column.extend([np.nan] * (before + 1 - len(column)))  # unknown now: a gap

    def close(self) -> None:
        """Write the numbers and finish the file."""
        for path, column in self._columns.items():
            if (style := style_of(path, self.names.legs)) is not None:
                colour, name = style
                lines = rr.SeriesLines(colors=[_rgba(colour)], names=[name])
                self._stream.log(path, lines, static=True)
            times = rr.TimeColumn(TIMELINE, duration=self._times_s)
            self._stream.send_columns(path, [times], rr.Scalars.columns(scalars=column))
        self._columns.clear()
        self._stream.flush()
        self._stream.disconnect()


def style_of(path: str, names: tuple[str, ...]) -> tuple[Colour, str] | None:
    """Return colour and name of a curve, None where the viewer may choose.

    Args:
        path: Where its numbers are, ``plots/force/HL/z_n/difference`` say.
        names: Leg names; differences of all legs stand in one plot.
    """
    *folders, last = path.split("/")
    if last in SERIES:
        return SERIES[last], last
    legs = [name for name in folders if name in names]
    if last == "difference" and legs:
        return to_rgb(leg_colour(names.index(legs[0]))), f"{legs[0]} difference"
    return None


def layout(names: tuple[str, ...]) -> rrb.Blueprint:
    """Return what is where when the file is opened.

    Args:
        names: Leg names.
    """

    def plot(name: str, *paths: str) -> rrb.TimeSeriesView:
        contents = [f"/plots/{path}" for path in paths]
        return rrb.TimeSeriesView(name=name, contents=contents, plot_legend=rrb.Corner2D.RightTop)

    eye = rrb.EyeControls3D(position=(-0.35, -0.95, 0.55), look_target=(0.25, 0.0, 0.0))
    scene = rrb.Spatial3DView(name="Robot", contents=[f"/{MAP_FRAME}/**"], eye_controls=eye)
    velocity = [f"velocity/vx_m_s/{who}" for who in ("true", "predicted", "estimated")]
    loads = [f"force/{name}/z_n/difference" for name in names]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                scene, rrb.TextLogView(name="Events", contents=["/news"]), row_shares=[3, 1]
            ),
            rrb.Vertical(
                plot("Forward velocity [m/s]", *velocity),
                plot("Predicted - true [m/s]", "velocity/vx_m_s/difference"),
                plot(f"Vertical force on {names[0]} [N]", f"force/{names[0]}/z_n/**"),
                plot("Vertical force, predicted - measured [N]", *loads),
                plot("Estimate, one sd [m]", "estimate/x_sd_m", "estimate/y_sd_m"),
            ),
            column_shares=[3, 2],
        ),
        collapse_panels=True,
    )


def _rows(vectors: list[FloatArray]) -> FloatArray:
    return np.array(vectors).reshape(-1, 3)


def _rgba(colour: Colour, alpha: float = 1.0) -> tuple[int, int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue, round(255 * alpha)
