"""Components of a compared walk, and their root-mean-square errors as a table."""

from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np

from model.values.arrays import FloatArray, known_mean, root_mean_square
from robot.console.table import Column, table_lines
from robot.study.walk_comparison import WalkComparison

COLUMNS = (
    Column("component"), Column("unit"),
    *(Column(name, ".2f") for name in ("spread", "viscous", "Coulomb", "support", "laws apart")),
)  # fmt: skip
PAPER_VISCOUS_US, PAPER_COULOMB_US = 190.0, 10_400.0
UNKNOWN = np.full(1, np.nan)  # of any length: what a model does not predict


class Component(NamedTuple):
    """One component of a walk, true and predicted, in ``unit``: (F,), or of each foot (F, N).

    What a model does not predict is ``UNKNOWN``.
    """

    name: str
    unit: str
    true: FloatArray
    viscous: FloatArray = UNKNOWN
    coulomb: FloatArray = UNKNOWN
    support: FloatArray = UNKNOWN


@dataclass(frozen=True, slots=True)
class ComponentError:
    """RMS errors of one component over a walk, in ``unit``; NaN where a model does not predict it.

    ``spread`` is that of the true values about their mean: what predicting a constant would miss; ``apart``
    is that of one law against the other.
    """

    component: str
    unit: str
    spread: float
    viscous: float
    coulomb: float
    support: float
    apart: float


def components(walk: WalkComparison) -> dict[str, Component]:
    """Return body velocity, tilt, horizontal forces and the share of each foot in Fz, by name."""
    laws = (walk.viscous, walk.coulomb)
    compared: list[Component] = []
    swayed: list[Component] = []
    for k, (name, unit) in enumerate((("vx", "mm/s"), ("vy", "mm/s"), ("yaw rate", "mrad/s"))):
        curves = (walk.velocity_B, *(law.velocity_B for law in laws))
        true, *predicted = (1e3 * velocity[:, k] for velocity in curves)
        compared.append(Component(name, unit, true, *predicted))
        if k < 2:
            with_sway = (velocity + 1e3 * walk.sway_B[:, k] for velocity in predicted)
            swayed.append(Component(f"{name} + sway", unit, true, *with_sway))
    compared += swayed
    for k, name in enumerate(("roll", "pitch")):
        tilt, support = 1e3 * walk.tilt_rad[:, k], 1e3 * walk.support_tilt_rad[:, k]
        compared.append(Component(name, "mrad", tilt, support=support))
    for k, name in enumerate(("Fx", "Fy")):
        predicted = [law.force_xy_B[..., k] for law in laws]
        compared.append(Component(name, "N", walk.force_n[..., k], *predicted))
    true, support = 1e2 * walk.true_share, 1e2 * walk.load_share
    compared.append(Component("Fz share", "%", true, support=support))
    return {one.name: one for one in compared}


def component_errors(walk: WalkComparison) -> dict[str, ComponentError]:
    """Return the errors of each component by name; forces over all feet together."""
    return {
        name: ComponentError(
            name,
            one.unit,
            spread=_rms(one.true - known_mean(one.true)),
            viscous=_rms(one.viscous - one.true),
            coulomb=_rms(one.coulomb - one.true),
            support=_rms(one.support - one.true),
            apart=_rms(one.viscous - one.coulomb),
        )
        for name, one in components(walk).items()
    }


def _rms(values: FloatArray) -> float:
    return float(root_mean_square(values.ravel()))


def error_table(walk: WalkComparison) -> tuple[str, ...]:
    """Return the table as lines of text: RMS, a dash where a model says nothing."""
    lines = [f"{walk.gait}, {len(walk.t_s)} frames, {np.ptp(walk.phase):.1f} cycles"]
    lines += table_lines(COLUMNS, [astuple(row) for row in component_errors(walk).values()])
    lines.append(
        f"time a frame, in a batch: viscous {walk.viscous.frame_us:.1f} us, Coulomb "
        f"{walk.coulomb.frame_us:.1f} us (the paper, tripod: {PAPER_VISCOUS_US:.0f} and "
        f"{PAPER_COULOMB_US:.0f} us)"
    )
    return tuple(lines)
