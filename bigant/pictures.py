"""Pictures in a notebook: those of the commands, as matplotlib figures whose axes can be changed."""

import base64
import html
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bigant.diagnosis import GapReport
from bigant.logs import Log
from bigant.prediction import GaitSamples
from bigant.tracks import Odometry
from model.systems.predict import SystemPrediction
from robot.gap_report.page import draw_traces
from robot.odometry.figure import drawing
from robot.report.figure_style import leg_colour
from robot.report.pictures import save_pictures
from robot.report.plots import STYLE, draw_log
from robot.study.model_plots import draw_predictions

NOTEBOOK_DPI = 90
Drawable: TypeAlias = Log | Odometry | GapReport | SystemPrediction | GaitSamples


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Picture:
    """Figures by title; a notebook shows them, and no window is opened.

    Attributes:
        figures: The figures, of matplotlib.
    """

    figures: Mapping[str, Figure]

    @property
    def axes(self) -> Mapping[str, list[Axes]]:
        """Axes of each figure by its title, to be drawn on, scaled and labelled."""
        return {title: figure.axes for title, figure in self.figures.items()}

    def save(self, out: str | Path) -> tuple[Path, ...]:
        """Write each figure to NAME-TITLE.png beside NAME.png; return the files.

        Raises:
            ValueError: It is another kind of file.
            RecordError: It cannot be written.
        """
        path = Path(out)
        if path.suffix != ".png":
            raise ValueError(f"a picture is written as .png, not {path}")
        return save_pictures(path, self.figures)

    def __repr__(self) -> str:
        """Return the titles."""
        return f"Picture of {', '.join(self.figures) or 'nothing'}"

    def _repr_html_(self) -> str:
        parts = []
        for title, figure in self.figures.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png", dpi=NOTEBOOK_DPI)
            data = base64.b64encode(buffer.getvalue()).decode("ascii")
            parts.append(f'<img alt="{html.escape(title)}" src="data:image/png;base64,{data}"/>')
        return "<br/>".join(parts)


def plot(result: Drawable, *titles: str) -> Picture:
    """Plot a log, odometry, a diagnosis, a prediction of the model, or a gait.

    Args:
        result: What to draw.
        titles: Only these figures, for example ``"Trajectory"`` of a log; all of them if none is named.

    Raises:
        ValueError: There is no figure of such a title.
        TypeError: It is nothing that can be drawn.
    """
    for kind, draw in _DRAWINGS.items():
        if isinstance(result, kind):
            figures = draw(result)
            break
    else:
        kinds = ", ".join(kind.__name__ for kind in _DRAWINGS)
        raise TypeError(f"plot draws {kinds}, not {type(result).__name__}")
    for title in titles:
        if title not in figures:
            raise ValueError(f"there is no figure {title!r}; there are {', '.join(figures)}")
    return Picture({title: figures[title] for title in titles or figures})


def _gait(samples: GaitSamples) -> dict[str, Figure]:
    """Angles of all legs over phase, and when each is in stance."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7, 4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        for leg, name in enumerate(samples.legs):
            colour = leg_colour(leg)
            top.plot(samples.phase, samples.angle_rad[:, leg], color=colour, lw=1.2, label=name)
            down = np.where(samples.stance[:, leg], float(leg), np.nan)
            bottom.plot(samples.phase, down, color=colour, lw=4, solid_capstyle="butt")
        top.set_ylabel("shaft angle [rad]")
        top.legend(ncols=2, fontsize=7)
        bottom.set_yticks(range(len(samples.legs)), samples.legs)
        bottom.set(xlabel="phase [cycles]", ylabel="stance")
        bottom.invert_yaxis()
    return {"Gait": figure}


_DRAWINGS: Mapping[type, Callable[..., dict[str, Figure]]] = {
    Log: draw_log,
    Odometry: lambda odometry: {"Odometry": drawing(odometry.comparison)},
    GapReport: lambda report: draw_traces(report.diagnosis),
    SystemPrediction: lambda prediction: {"Prediction": draw_predictions([prediction])},
    GaitSamples: _gait,
}
