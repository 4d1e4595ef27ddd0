"""Root-mean-square errors of a compared walk, component by component, as a table."""

from dataclasses import astuple, dataclass

import numpy as np

from model.values.arrays import FloatArray, root_mean_square
from robot.console.table import Column, table_lines
from robot.study.walk_comparison import WalkComparison

COLUMNS = (
    Column("component"), Column("unit"),
    *(Column(name, ".2f") for name in ("spread", "viscous", "Coulomb", "support", "laws apart")),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ComponentError:
    """Errors of one component over a walk; NaN where a model does not predict it.

    Attributes:
        component: Its name.
        unit: Unit of all figures.
        spread: RMS of the true values about their mean: what predicting a constant would miss.
        viscous: RMS error of the viscous-Coulomb ansatz.
        coulomb: RMS error of Coulomb's law.
        support: RMS error of the spring support model.
        apart: RMS difference of the two laws.
    """

    component: str
    unit: str
    spread: float
    viscous: float
    coulomb: float
    support: float
    apart: float


PAPER_VISCOUS_US, PAPER_COULOMB_US = 190.0, 10_400.0


def component_errors(walk: WalkComparison) -> tuple[ComponentError, ...]:
    """Return the errors of body velocity, tilt and forces; forces over all feet together."""
    none = np.full(1, np.nan)
    true, viscous, coulomb, sway = (
        1e3 * array
        for array in (
            walk.velocity_B, walk.viscous.velocity_B, walk.coulomb.velocity_B, walk.sway_B
        )
    )  # fmt: skip
    velocity = tuple(enumerate((("vx", "mm/s"), ("vy", "mm/s"), ("yaw rate", "mrad/s"))))
    rows = [
        _row(name, unit, true[:, k], viscous[:, k], coulomb[:, k], none)
        for k, (name, unit) in velocity
    ]
    rows += [
        _row(f"{name} + sway", unit, true[:, k], viscous[:, k] + sway[:, k],
             coulomb[:, k] + sway[:, k], none)
        for k, (name, unit) in velocity[:2]
    ]  # fmt: skip
    rows += [
        _row(name, "mrad", 1e3 * walk.tilt_rad[:, k], none, none, 1e3 * walk.support_tilt_rad[:, k])
        for k, name in enumerate(("roll", "pitch"))
    ]
    viscous, coulomb = walk.viscous.force_xy_B, walk.coulomb.force_xy_B
    rows += [
        _row(name, "N", walk.force_n[..., k], viscous[..., k], coulomb[..., k], none)
        for k, name in enumerate(("Fx", "Fy"))
    ]
    rows.append(_row("Fz share", "%", 1e2 * walk.true_share, none, none, 1e2 * walk.load_share))
    return tuple(rows)


def _row(
    name: str,
    unit: str,
    true: FloatArray,
    viscous: FloatArray,
    coulomb: FloatArray,
    support: FloatArray,
) -> ComponentError:
    return ComponentError(
        name,
        unit,
        spread=_rms(true - _mean(true)),
        viscous=_rms(viscous - true),
        coulomb=_rms(coulomb - true),
        support=_rms(support - true),
        apart=_rms(viscous - coulomb),
    )


def _rms(values: FloatArray) -> float:
    """Over frames and feet together."""
    return float(root_mean_square(values.ravel()))


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan


def error_of(errors: tuple[ComponentError, ...], component: str) -> ComponentError:
    """Return the row of a component."""
    return next(row for row in errors if row.component == component)


def error_table(walk: WalkComparison) -> tuple[str, ...]:
    """Return the table as lines of text: RMS, a dash where a model says nothing."""
    lines = [f"{walk.gait}, {len(walk.t_s)} frames, {np.ptp(walk.phase):.1f} cycles"]
    lines += table_lines(COLUMNS, [astuple(row) for row in component_errors(walk)])
    lines.append(
        f"time a frame, in a batch: viscous {walk.viscous.frame_us:.1f} us, Coulomb "
        f"{walk.coulomb.frame_us:.1f} us (the paper, tripod: {PAPER_VISCOUS_US:.0f} and "
        f"{PAPER_COULOMB_US:.0f} us)"
    )
    return tuple(lines)
