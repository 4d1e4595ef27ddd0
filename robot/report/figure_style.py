"""Colours and small helpers shared by our versions of the paper's figures.

As in the paper: truth red, viscous-Coulomb orange, Coulomb blue, spring support purple.
"""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

TRUTH, VISCOUS, COULOMB, SUPPORT = "#DD3B3B", "#F08A00", "#1F6FB4", "#7A3E9D"
NEUTRAL = "#555555"
# one colour a leg, distinct for the colour-blind; recycled beyond the eighth
LEGS = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#0072B2", "#D55E00", "#B8A800", "#333333")
TRUTH_WIDTH, MODEL_WIDTH = 3.0, 1.1


def leg_colour(index: int) -> str:
    """Return the colour of a leg by its number."""
    return LEGS[index % len(LEGS)]


def line(colour: str, label: str, width: float = MODEL_WIDTH, style: str = "-") -> Line2D:
    """Return a sample line for a legend."""
    return Line2D([], [], color=colour, lw=width, ls=style, label=label)


def model_legend(figure: Figure, *, support: bool = True) -> None:
    """Put the legend of truth and models above all panels, where it covers nothing."""
    handles = [
        line(TRUTH, "true", TRUTH_WIDTH),
        line(VISCOUS, "viscous-Coulomb", 1.8),
        line(COULOMB, "Coulomb", 1.8),
    ]
    if support:
        handles.append(line(SUPPORT, "spring support", 1.8))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))


def panel_letter(ax: Axes, letter: str) -> None:
    """Write the letter of a panel at its upper left, outside the axes."""
    ax.set_title(letter, loc="left", fontweight="bold")
