"""Pictures of the first day: the robot and its steps by what was found, and each leg against its goal."""

from collections.abc import Sequence
from functools import lru_cache

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from robot.bringup.first_day.curve import DayCurve
from robot.bringup.first_day.record import Record
from robot.bringup.first_day.steps import STEPS
from robot.bringup.preflight.finding import Finding
from robot.bringup.preflight.page import STATES, WORST_FIRST
from robot.config.robot_file import RobotConfig
from robot.report.page import PagePicture
from robot.report.pictures import page_picture
from robot.report.plan_view import (
    PlanState,
    draw_plan,
    draw_rows,
    leg_places,
    state_legend,
)
from robot.report.plots import STYLE

MEASURED, EXPECTED = "#0072B2", "#D55E00"
FEW = 20  # points that are drawn one by one


def draw_day(record: Record, config: RobotConfig) -> Figure:
    """Draw the robot from above beside a row of marks for each step."""
    places = leg_places(config)
    found = [one for outcome in record.latest.values() for one in outcome.findings]
    legs = [_state_of(name, found) for name in places.names]
    rows = {}
    for step in STEPS:
        outcome = record.latest.get(step.number)
        states = [STATES[one.verdict] for one in outcome.findings] if outcome else []
        rows[f"{step.number} {step.key}"] = states or [PlanState.UNKNOWN]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 4.2), layout="constrained")
        plan, steps = figure.subplots(1, 2, width_ratios=(1.2, 1))
        draw_plan(plan, places, legs)
        draw_rows(steps, rows, "steps", "finding")
        state_legend(figure, [*legs, *(state for states in rows.values() for state in states)])
    return figure


@lru_cache(maxsize=2 * len(STEPS))
def curves_picture(
    name: str, number: str, curves: tuple[DayCurve, ...], sides: tuple[tuple[str, ...], ...]
) -> PagePicture:
    """Return ``draw_curves`` as a picture; the page is written after each step, most stay the same."""
    return page_picture(draw_curves(curves, sides), name, number)


def draw_curves(curves: Sequence[DayCurve], legs: Sequence[Sequence[str]]) -> Figure:
    """Draw each leg where it is on the robot.

    Args:
        curves: One a leg.
        legs: Names of the legs on the left and on the right, each from the rear to the front.
    """
    by_leg = {one.leg: one for one in curves}
    sides = [[leg for leg in side if leg in by_leg] for side in legs]
    sides = [side for side in sides if side]
    across = max(len(side) for side in sides)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 1.4 + 1.5 * len(sides)), layout="constrained")
        axes = figure.subplots(len(sides), across, squeeze=False, sharey=True)
        for row, side in enumerate(sides):
            for ax in axes[row, len(side) :]:
                ax.remove()
            for column, leg in enumerate(side):
                one, ax = by_leg[leg], axes[row, column]
                marker = "o" if len(one.x) < FEW else "None"
                if one.expected:
                    ax.plot(one.x, one.expected, color=EXPECTED, lw=2.2, label="expected")
                ax.plot(
                    one.x,
                    one.measured,
                    marker=marker,
                    color=MEASURED,
                    lw=1.1,
                    ms=5,
                    ls="-",
                    label="measured",
                )
                ax.set(title=one.leg, xlabel=one.across, ylabel=one.up if column == 0 else "")
        named = {"measured": MEASURED} | ({"expected": EXPECTED} if curves[0].expected else {})
        handles = [Line2D([], [], color=colour, label=name, lw=1.1 if name == "measured" else 2.2)
                   for name, colour in named.items()]  # fmt: skip
        figure.legend(handles=handles, loc="outside upper center", ncols=2, frameon=False)
    return figure


def _state_of(leg: str, found: Sequence[Finding]) -> PlanState:
    """The worst that is known of a leg: findings are named after it, or are about it."""
    states = {STATES[one.verdict] for one in found if leg == one.name or leg in one.legs}
    return next((one for one in WORST_FIRST if one in states), PlanState.UNKNOWN)
