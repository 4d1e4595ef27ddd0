"""The robot from above, each leg marked by what was found out about it, and rows of marks next to it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from model.values.arrays import FloatArray
from robot.config.robot_file import RobotConfig
from robot.design.review import foot_path
from robot.report.figure_style import NEUTRAL

BODY_MARGIN, NAME_ASIDE, LINE, SIDE_ROOM = 0.12, 0.16, 0.1, 0.84  # of the size of the robot


class PlanState(Enum):
    """How something was found: the word in the legend."""

    GOOD = "ok"
    WARNED = "warning"
    BAD = "failed"
    UNKNOWN = "not checked"


class _Look(NamedTuple):
    """Colour (Okabe and Ito), marker and size: distinct in black and white, too."""

    colour: str
    marker: str
    size: float


LOOKS = {
    PlanState.GOOD: _Look("#009E73", "o", 1.0),
    PlanState.WARNED: _Look("#E69F00", "^", 1.1),
    PlanState.BAD: _Look("#D55E00", "s", 0.95),
    PlanState.UNKNOWN: _Look("#999999", "D", 0.9),
}


@dataclass(frozen=True, slots=True, eq=False)
class LegPlaces:
    """Where the legs of a robot are, N legs.

    Attributes:
        names: Of the legs.
        shaft_m: Their shafts in the body frame, (N, 2) [m]: forward, left.
        foot_m: Their feet with the joints at zero, (N, 2) [m].
    """

    names: tuple[str, ...]
    shaft_m: FloatArray
    foot_m: FloatArray

    @property
    def sides(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the legs on the left and on the right, each from the rear to the front."""
        along = np.argsort(self.shaft_m[:, 0], kind="stable").tolist()
        left = self.shaft_m[:, 1] > float(self.shaft_m[:, 1].mean())
        return (
            tuple(self.names[leg] for leg in along if left[leg]),
            tuple(self.names[leg] for leg in along if not left[leg]),
        )


def leg_places(config: RobotConfig) -> LegPlaces:
    """Return where the legs of a robot file are."""
    legs = config.parameters.legs
    shafts = legs.shaft_position[:, :2]
    return LegPlaces(tuple(legs.names), shafts, shafts + foot_path(config)[0][:, :2])


def draw_plan(
    ax: Axes, places: LegPlaces, states: Sequence[PlanState], words: Sequence[str] = ()
) -> None:
    """Draw the robot from above, forward to the right.

    Args:
        ax: Where.
        places: Of N legs.
        states: One a leg.
        words: A few letters a leg, next to its name; empty for none.
    """
    shafts, feet = 1e3 * places.shaft_m, 1e3 * places.foot_m
    low, high = shafts.min(axis=0), shafts.max(axis=0)
    size = np.maximum(high - low, 0.3 * max(float(np.ptp(shafts)), 1.0))
    middle = (low + high) / 2
    half = size / 2 * np.array([1.0 + 2 * BODY_MARGIN, 0.62])
    nose = middle + half * (1.22, 0.0)
    corners = [middle - half, middle + half * (1, -1), nose, middle + half, middle + half * (-1, 1)]
    ax.add_patch(Polygon(np.array(corners), closed=True, fc=NEUTRAL, ec=NEUTRAL, alpha=0.14, lw=1))
    extras = [*words, *[""] * len(places.names)]
    for leg, (shaft, foot) in enumerate(zip(shafts, feet, strict=True)):
        side = 1 if shaft[1] >= middle[1] else -1
        hip = np.array([shaft[0], middle[1] + side * half[1]])
        ax.plot(*np.array([hip, shaft, foot]).T, color=NEUTRAL, lw=3.0, alpha=0.6)
        look = LOOKS[states[leg]]
        ax.plot(*shaft, look.marker, color=look.colour, ms=15 * look.size, ls="None")
        for row, text in enumerate((places.names[leg], extras[leg])):
            at = shaft[1] + side * (NAME_ASIDE + row * LINE) * size[1]
            ax.text(shaft[0], at, text, ha="center", va="center")
    ax.text(middle[0], middle[1], "forward →", ha="center", va="center")
    behind = min(float(feet[:, 0].min()), float(corners[0][0])) - 0.1 * size[0]
    ahead = max(float(feet[:, 0].max()), float(nose[0])) + 0.1 * size[0]
    ax.set(
        xlim=(behind, ahead), ylim=tuple(middle[1] + side * SIDE_ROOM * size[1] for side in (-1, 1))
    )
    ax.set_aspect("equal", adjustable="box")
    ax.set(xlabel="x [mm]", ylabel="y [mm]", title="robot from above")
    ax.grid(visible=False)


def draw_rows(ax: Axes, rows: Mapping[str, Sequence[PlanState]], title: str, across: str) -> None:
    """Draw a mark for each of several things in rows, the first row on top.

    Args:
        ax: Where.
        rows: What each row is of, and its marks.
        title: Above them.
        across: What is counted to the right.
    """
    most = max((len(states) for states in rows.values()), default=1)
    for row, states in enumerate(rows.values()):
        for state in PlanState:
            at = [k + 1 for k, one in enumerate(states) if one is state]
            look = LOOKS[state]
            ax.plot(
                at, [-row] * len(at), look.marker, color=look.colour, ms=8 * look.size, ls="None"
            )
    ax.set_yticks([-row for row in range(len(rows))], list(rows))
    ax.set(xlim=(0.3, most + 0.7), ylim=(-len(rows) + 0.4, 0.6), title=title, xlabel=across)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.grid(visible=False)


def state_legend(figure: Figure, shown: Sequence[PlanState]) -> None:
    """Name the marks that are shown, above all panels."""
    handles = [
        Line2D([], [], color=LOOKS[one].colour, marker=LOOKS[one].marker, ls="None",
               ms=8 * LOOKS[one].size, label=one.value)
        for one in PlanState if one in shown
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), frameon=False)
