"""What is drawn in a panel of a figure, curve by curve, as marks of a plot of Bokeh.

Places are read back in the units of the axes, whatever an artist was drawn in.
"""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from bokeh.models import ColumnDataSource, LinearColorMapper, Range1d
from bokeh.models.annotations import Arrow, ColorBar, Label, Span
from bokeh.models.annotations.arrows import VeeHead
from bokeh.models.glyphs import Image
from bokeh.plotting import figure as BokehPlot  # noqa: N812 - a class with a small name
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation, Text

from model.values.arrays import FloatArray
from robot.report.thinning import kept_rows

MOST_IN_PLOT = 6000  # points, shared by the curves of a panel
BLACK = "#000000"  # ``moving.js`` makes it the page's ink
DASHES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dashdot", "None": "solid"}
# markers of matplotlib that our figures use, by Bokeh's names
MARKERS = {".": "circle", "o": "circle", "|": "dash", "x": "x", ">": "triangle", "^": "triangle",
           "s": "square", "*": "star", "D": "diamond", "+": "cross"}  # fmt: skip


def drawn_in(ax: Axes) -> list[Artist]:
    """Return what is drawn in axes, from back to front."""
    texts = [one for one in ax.texts if one.get_text() or isinstance(one, Annotation)]
    drawn: list[Artist] = [*ax.images, *ax.collections, *ax.patches, *ax.lines, *texts]
    return sorted((one for one in drawn if one.get_visible()), key=lambda one: one.get_zorder())


def add_mark(plot: BokehPlot, ax: Axes, artist: Artist, name: str) -> None:
    """Draw in a plot what an artist draws in axes, under a name by which it can be hidden; empty for none.

    Raises:
        TypeError: It has no counterpart in a plot.
    """
    named = name or None
    match artist:
        case Line2D():
            _add_line(plot, ax, artist, named)
        case AxesImage():
            _add_image(plot, artist)
        case PolyCollection():
            paths = [np.asarray(one.vertices, dtype=np.float64) for one in artist.get_paths()]
            outlines = [_in_data(ax, artist, one) for one in paths if len(one)]
            _add_shades(plot, outlines, np.atleast_2d(artist.get_facecolor()), None, named)
        case Patch():
            path = artist.get_path().transformed(artist.get_transform() - ax.transData)
            whole = [
                np.asarray(one, dtype=np.float64) for one in path.to_polygons(closed_only=False)
            ]
            edge = to_hex(artist.get_edgecolor()) if artist.get_linewidth() else None
            _add_shades(plot, whole, np.atleast_2d(artist.get_facecolor()), edge, named)
        case Annotation() if artist.arrow_patch is not None:
            (x, y), (x_end, y_end) = artist.get_position(), artist.xy
            look: dict[str, Any] = {"line_color": BLACK, "line_width": 1}
            look["end"] = VeeHead(size=7, fill_color=BLACK, line_color=BLACK)
            plot.add_layout(Arrow(x_start=x, y_start=y, x_end=x_end, y_end=y_end, **look))
        case Text():
            _add_text(plot, ax, artist)
        case _:
            raise TypeError(f"{type(artist).__name__} has no counterpart in a plot of a page")


def range_of(limits: tuple[float, float]) -> Range1d:
    """Return the range of an axis; it may run backwards."""
    return Range1d(start=float(limits[0]), end=float(limits[1]))


def _in_data(ax: Axes, artist: Artist, places: FloatArray) -> FloatArray:
    """Places in the units of the axes, (K, 2), of an artist that may be drawn in shares of the axes."""
    if artist.get_transform() == ax.transData:
        return places
    moved: FloatArray = (artist.get_transform() - ax.transData).transform(places)
    return moved


def _add_line(plot: BokehPlot, ax: Axes, line: Line2D, name: str | None) -> None:
    places = np.asarray(line.get_xydata(), dtype=np.float64)
    colour, width = to_hex(line.get_color()), float(line.get_linewidth())
    dash, marker = DASHES[str(line.get_linestyle())], str(line.get_marker())
    if len(places) == 0:
        return
    if len(places) == 2 and marker == "None":
        look: dict[str, Any] = {
            "line_color": colour,
            "line_dash": dash,
            "line_width": width,
            "name": name,
        }
        if line.get_transform() == ax.get_yaxis_transform(which="grid"):
            plot.add_layout(Span(dimension="width", location=float(places[0, 1]), **look))
            return
        if line.get_transform() == ax.get_xaxis_transform(which="grid"):
            plot.add_layout(Span(dimension="height", location=float(places[0, 0]), **look))
            return
    places = _in_data(ax, line, places)
    most = MOST_IN_PLOT // max(1, len(ax.lines))
    places = places[kept_rows(places[:, 0], places[:, 1], most)].astype(np.float32)
    source = ColumnDataSource({"x": places[:, 0], "y": places[:, 1]})
    if line.get_linestyle() != "None":
        plot.line("x", "y", source=source, color=colour, line_dash=dash, name=name,
                  line_width=max(1.0, 1.2 * width), alpha=line.get_alpha() or 1.0)  # fmt: skip
    if marker != "None":
        plot.scatter("x", "y", source=source, marker=MARKERS[marker], color=colour, name=name,
                     size=1.3 * float(line.get_markersize()),
                     angle=np.pi / 2 if marker == "|" else 0.0)  # fmt: skip


def _add_shades(
    plot: BokehPlot,
    outlines: Sequence[FloatArray],
    faces: FloatArray,
    edge: str | None,
    name: str | None,
) -> None:
    """Areas of one colour, the first of ``faces``, (K, 4)."""
    if not len(outlines) or not len(faces):
        return
    red, green, blue, alpha = to_rgba(tuple(faces[0]))
    sides = {
        side: [one[:, k].astype(np.float32) for one in outlines] for k, side in enumerate("xy")
    }
    source = ColumnDataSource(dict(sides))
    plot.patches("x", "y", source=source, name=name, line_color=edge, line_width=0.8,
                 fill_color=to_hex((red, green, blue)), fill_alpha=alpha)  # fmt: skip


def _add_image(plot: BokehPlot, image: AxesImage) -> None:
    """A map of values with its bar of colours; what is not known stays clear."""
    left, right, low, high = image.get_extent()
    least, most = image.get_clim()
    cmap = image.get_cmap()
    palette = [to_hex(cmap(level)) for level in np.linspace(0.0, 1.0, 256)]
    colours = LinearColorMapper(palette=palette, low=least, high=most, nan_color="rgba(0, 0, 0, 0)")
    values = np.ma.filled(np.ma.asarray(image.get_array()).astype(np.float32), np.nan)
    source = ColumnDataSource({"image": [values]})
    place: dict[str, Any] = {"x": left, "y": low, "dw": right - left, "dh": high - low}
    plot.add_glyph(source, Image(image="image", color_mapper=colours, **place))
    if image.colorbar is not None:
        words = image.colorbar.ax.get_ylabel()
        plot.add_layout(
            ColorBar(color_mapper=colours, title=words, width=10, name="colours"), "right"
        )


def _add_text(plot: BokehPlot, ax: Axes, text: Text) -> None:
    ((x, y),) = _in_data(ax, text, np.array([text.get_position()], dtype=np.float64))
    baseline: Literal["middle", "bottom"] = "bottom"
    if text.get_verticalalignment() == "center":
        baseline = "middle"
    plot.add_layout(Label(x=float(x), y=float(y), text=text.get_text(), text_font_size="12px",
                          text_align=text.get_horizontalalignment(),
                          text_baseline=baseline))  # fmt: skip
