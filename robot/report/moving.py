"""Figures that zoom and hover: each panel as a plot of Bokeh, whose wheel carries its browser code.

A figure is drawn once, with matplotlib: that is the still picture (PNG, paper, no scripts). What is drawn
in it is read back (``plot_marks``); ``templates/moving.js`` puts the plots in the still picture's place.
"""

import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from bokeh.embed import json_item
from bokeh.models import (
    BoxZoomTool,
    FixedTicker,
    PanTool,
    ResetTool,
    SaveTool,
    WheelZoomTool,
)
from bokeh.plotting import figure as BokehPlot  # noqa: N812 - a class with a small name
from bokeh.resources import Resources
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator

from robot.report.packed import script_json
from robot.report.plot_marks import DASHES, add_mark, drawn_in, range_of

PX_PER_IN = 72.0
AXIS_PX, TITLE_PX = 40, 22  # what labels below a panel and its title take
LEAST_PX, LEAST_ALONE_PX = 80, 200  # height of one panel among others, and of a figure's only one
EDGE_PX = 64  # left of the axes: panels one below the other begin at one place
COLOUR_BAR = "<colorbar>"  # matplotlib's label of its axes
PLANE = re.compile(r"[xyz] \[")  # the label of an axis in space
TIME = re.compile(r"time\b.*\[s\]")


class Mark(NamedTuple):
    """A name in the legend: its colour, how its line is drawn, and whether it is a shade."""

    name: str
    colour: str
    dash: str
    shade: bool


def moving_json(figure: Figure) -> str:
    """Return the plots of a figure as JSON that may stand in a page: panels, columns, names of curves.

    Raises:
        TypeError: Something is drawn in it that has no counterpart in a plot.
    """
    _settle(figure)
    marks = list(_marks(figure))
    axes = [ax for ax in figure.axes if ax.get_label() != COLOUR_BAR]
    grids = [spec.get_gridspec() for ax in axes if (spec := ax.get_subplotspec())]
    panels = [_panel(ax, marks) for ax in axes]
    drawn = {name for panel in panels for name in panel["names"]}
    plots = {
        "panels": panels,
        "columns": max((grid.ncols for grid in grids), default=1),
        "legend": [one._asdict() for one in marks if one.name in drawn],
    }
    return script_json(plots)


def _settle(figure: Figure) -> None:
    """Find the places of panels once: laid out and drawn for each use, a page takes longer."""
    layout = figure.get_layout_engine()
    if layout is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")


@cache
def library() -> str:
    """Return Bokeh's browser code, 1.3 MB: what draws the plots of a page."""
    code, *_ = Resources(mode="inline", components=["bokeh"], minified=True).js_raw
    return str(code)


def _marks(figure: Figure) -> Iterator[Mark]:
    """What the legends of a figure and of its axes name, each once."""
    names = set()
    legends = [*figure.legends, *(one for ax in figure.axes if (one := ax.get_legend()))]
    for legend in legends:
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            if text.get_text() not in names and isinstance(handle, Line2D | Patch):
                names.add(text.get_text())
                yield _mark(text.get_text(), handle)


def _mark(name: str, handle: Line2D | Patch) -> Mark:
    if isinstance(handle, Line2D):
        dash = DASHES[str(handle.get_linestyle())]
        return Mark(name, to_hex(handle.get_color()), dash, shade=False)
    return Mark(name, to_hex(handle.get_facecolor()), "solid", shade=True)


def _name(artist: object, marks: Sequence[Mark]) -> str:
    """The name of what is drawn: its own, or that of what looks the same in a legend; empty for none."""
    if not isinstance(artist, Line2D | Patch | PolyCollection):
        return ""
    own = str(artist.get_label())
    if own and not own.startswith("_"):
        return own
    if isinstance(artist, Line2D):
        look = _mark("", artist)[1:]
        same = [one.name for one in marks if one[1:] == look]
    else:
        faces = np.atleast_2d(np.asarray(artist.get_facecolor()))
        colour = to_hex(tuple(faces[0])) if len(faces) else ""
        same = [one.name for one in marks if one.shade and one.colour == colour]
    return same[0] if same else ""


def _panel(ax: Axes, marks: Sequence[Mark]) -> dict[str, Any]:
    plot, names = _empty_plot(ax), []
    for artist in drawn_in(ax):
        names.append(_name(artist, marks))
        add_mark(plot, ax, artist, names[-1])
    (left, right), (low, high), box = ax.get_xlim(), ax.get_ylim(), ax.get_window_extent()
    in_plane = PLANE.match(ax.get_xlabel()) and PLANE.match(ax.get_ylabel())
    stretch = (box.height / abs(high - low)) / (box.width / abs(right - left))
    return {
        "item": _same_ids(dict(json_item(plot))),
        "names": [*dict.fromkeys(name for name in names if name)],
        "time": bool(TIME.match(_x_label(ax))),
        "labels": [" ".join(one.split()) for one in (_x_label(ax), ax.get_ylabel())],
        "stretch": stretch if in_plane else None,
    }


def _x_label(ax: Axes) -> str:
    """The label of the x axis: its own, or that of the lowest panel it shares the axis with."""
    shared = [one.get_xlabel() for one in ax.get_shared_x_axes().get_siblings(ax)]
    return ax.get_xlabel() or next((label for label in shared if label), "")


def _empty_plot(ax: Axes) -> BokehPlot:
    """A plot with the axes, the title and the tools of a panel."""
    whole = ax.get_figure(root=True)
    assert whole is not None
    height_in = float(ax.get_position().height * whole.get_size_inches()[1])
    titles = [ax.get_title(loc="left"), ax.get_title(loc="center"), ax.get_title(loc="right")]
    title = "   ".join(text for text in titles if text)
    rows = len({ax.get_position().y0 for ax in whole.axes})
    named = isinstance(
        ax.yaxis.get_major_locator(), FixedLocator
    )  # rows with names: as high as they need
    labelled = bool(ax.xaxis.get_tick_params()["labelbottom"])
    least_px = LEAST_PX if rows > 1 or named else LEAST_ALONE_PX
    around_px = (AXIS_PX if labelled else 0) + (TITLE_PX if title else 0)
    plot = BokehPlot(
        height=max(least_px, round(height_in * PX_PER_IN)) + around_px, sizing_mode="stretch_width",
        x_range=range_of(ax.get_xlim()), y_range=range_of(ax.get_ylim()),
        x_axis_type=_scale(ax.get_xscale()), y_axis_type=_scale(ax.get_yscale()),
        x_axis_label=ax.get_xlabel() or None, y_axis_label=ax.get_ylabel() or None,
        title=title or None, tools="", toolbar_location="above", toolbar_inner=True,
        min_border=4, min_border_left=EDGE_PX, outline_line_color=None,
        background_fill_alpha=0, border_fill_alpha=0,
    )  # fmt: skip
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    zoom, wheel = BoxZoomTool(dimensions="auto"), WheelZoomTool(modifiers="ctrl")
    plot.add_tools(PanTool(), zoom, wheel, ResetTool(), SaveTool())
    plot.toolbar.active_drag, plot.toolbar.active_scroll = zoom, wheel
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = axis.major_label_text_font_size = "12px"
        axis.minor_tick_line_color = None
    plot.xaxis.visible = labelled
    if named:
        ticks = [float(at) for at in np.asarray(ax.yaxis.get_major_locator()())]
        names = ax.yaxis.get_major_formatter().format_ticks(ticks)
        plot.yaxis.ticker = FixedTicker(ticks=ticks)
        plot.yaxis.major_label_overrides = dict(zip(ticks, names, strict=True))
        plot.ygrid.visible = False
    return plot


def _scale(name: str) -> Literal["linear", "log"]:
    return "log" if name == "log" else "linear"


def _same_ids(item: dict[str, Any]) -> dict[str, Any]:
    """The same plot with ids of its own count: a page does not change from run to run."""
    text = json.dumps(item, allow_nan=False)
    for number, one in enumerate(dict.fromkeys(re.findall(r'"id": "(p\d+)"', text))):
        text = text.replace(f'"{one}"', f'"q{number}"')
    renamed: dict[str, Any] = json.loads(text)
    return renamed
