"""Where the gap lies: stages, channels, joints, phase of the gait, bands, time.

Under ``Drive.MEASURED`` a stage's residual is its own; under ``Drive.COMMAND`` it holds what came down the
chain as well. Single cells are tested together, by the largest statistic under random signs of blocks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gap.diagnosis.comparison.joint_ranking import JointGap, rank_joints
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.phase_bins import PHASE_BINS, phase_bins
from model.values.arrays import FloatArray, IntArray

FLIPS = 399
FEWEST_BLOCKS = 5
SHOWN = 10
CELL_LEVEL = 0.05
# What remains at the joint of a named cause: standard errors, and times the clearest elsewhere.
CLEAR_CELL, CLEARER = 10.0, 1.3
# Signs that are all alike give the statistic itself; rounding must not say whether it is as large.
AS_LARGE = 1.0 - 1e-9


@dataclass(frozen=True, slots=True)
class StageGap:
    """One stage.

    Attributes:
        own: Energy over expectation of its channels when fed what was measured (1 is none); NaN if unseen.
        end_to_end: The same when all stages are fed commands; NaN where runs have none.
        share: Its own energy above expectation over that of all stages, 0 to 1.
    """

    stage: str
    own: float
    end_to_end: float
    share: float


@dataclass(frozen=True, slots=True)
class PhaseCell:
    """A channel in a part of the gait.

    Attributes:
        joint: Its joint, empty for the body.
        phase: Middle of the phase bin, 0 to 1; NaN where there are no cycles.
        mean: Mean difference, measured minus predicted, in units of the noise.
        statistic: Mean over its standard error.
        p: Chance of so large a statistic anywhere in the map.
    """

    channel: str
    joint: str
    stage: str
    phase: float
    mean: float
    statistic: float
    p: float


@dataclass(frozen=True, slots=True)
class ChannelGap:
    """A channel of one joint.

    Attributes:
        excess: Energy over expectation; NaN where nothing was compared.
        bands: Shares of its energy: drift, harmonics 1 to 3, 4 to 10, above; NaN without cycles.
        thirds: Energy over expectation in each third of the trials.
        phases: Energy over expectation in each phase bin.
    """

    channel: str
    joint: str
    stage: str
    excess: float
    bands: tuple[float, ...]
    thirds: tuple[float, ...]
    phases: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Where:
    """The map: stages in the order of the chain, joints by their part, channels, largest differences."""

    stages: tuple[StageGap, ...]
    joints: tuple[JointGap, ...]
    channels: tuple[ChannelGap, ...]
    cells: tuple[PhaseCell, ...]

    @property
    def stage(self) -> str:
        """Stage with the largest share; empty if none is above expectation."""
        best = max(self.stages, key=lambda one: one.share)
        return best.stage if best.share > 0 else ""


def where(local: Evidence, end_to_end: Evidence | None, residual: FloatArray, seed: int) -> Where:
    """Make the map.

    Args:
        local: The trials under ``Drive.MEASURED``, or commands if the simulator is one piece.
        end_to_end: The same under ``Drive.COMMAND``; None where runs have no commands.
        residual: Whitened residual of ``local`` that is to be mapped, (F, C).
        seed: Of the random signs.
    """
    excess = local.excess(residual)
    bins = np.concatenate([phase_bins(part) for part in local.parts])
    above = _above(local, excess)
    return Where(
        _stages(local, end_to_end, excess, above),
        rank_joints(local, end_to_end or local, above),
        _channels(local, residual, excess, bins),
        _cells(local, residual, bins, seed),
    )


def _above(local: Evidence, excess: FloatArray) -> FloatArray:
    """Energy of each channel above expectation, (C,); what noise alone leaves above it is no gap."""
    count = local.count.sum(axis=0)
    above = np.where(np.isfinite(excess), np.fmax(excess - 1.0, 0.0) * count, 0.0)
    return np.where(excess > 1.0 + 3.0 * np.sqrt(2.0 / np.fmax(count, 1.0)), above, 0.0)


def _stages(
    local: Evidence, end_to_end: Evidence | None, excess: FloatArray, above: FloatArray
) -> tuple[StageGap, ...]:
    simulator = local.simulator
    whole = np.full(len(excess), np.nan)
    if end_to_end is not None:
        whole = end_to_end.excess(end_to_end.base)
    total = float(above.sum())
    out = []
    for stage in simulator.stages:
        on = np.array([channel.stage == stage for channel in simulator.channels])
        seen = on & np.isfinite(excess)
        out.append(
            StageGap(
                stage,
                float(np.mean(excess[seen])) if seen.any() else np.nan,
                float(np.nanmean(whole[seen])) if np.isfinite(whole[seen]).any() else np.nan,
                float(above[on].sum()) / total if total > 0 else 0.0,
            )
        )
    return tuple(out)


def _cells(
    evidence: Evidence, residual: FloatArray, bins: IntArray, seed: int
) -> tuple[PhaseCell, ...]:
    """The largest differences that are above chance; none where there are too few blocks to test them."""
    channels = evidence.simulator.channels
    cyclic = bool(bins.any())
    means, roots = [], []
    for one in range(PHASE_BINS if cyclic else 1):
        on = (bins == one)[:, None]
        means.append(evidence.per_block(residual * on))
        roots.append(evidence.per_block(evidence.frame_count * on))
    total, count = np.stack(means, axis=1), np.stack(roots, axis=1)  # (B, bins, C)
    frames = np.where(count > 0, count, np.inf)
    dependence = evidence.floor.dependence
    # whitened residuals carry the root of the dependence; undone here, a mean is in units of the noise
    value = total / (frames * np.sqrt(dependence))
    # a run hardly ever ends with its cycle: a block that has only some phases says nothing of the others
    whole = np.all(np.any(count > 0, axis=2), axis=1)
    value, count = value[whole], count[whole]
    blocks = len(value)
    known = (count > 0).all(axis=0).ravel()
    if blocks < FEWEST_BLOCKS or not known.any():
        return ()
    mean, statistic, chance = cell_chances(value.reshape(blocks, -1)[:, known], seed)
    order = np.argsort(-np.abs(statistic), kind="stable")[:SHOWN]
    places = np.flatnonzero(known)
    cells = []
    for i in order:
        bin_at, channel = divmod(int(places[i]), len(channels))
        p = float(chance[i])
        if p <= CELL_LEVEL:
            c = channels[channel]
            middle = (bin_at + 0.5) / PHASE_BINS if cyclic else np.nan
            cells.append(
                PhaseCell(c.name, c.joint, c.stage, middle, float(mean[i]), float(statistic[i]), p)
            )
    return tuple(cells)


def cell_chances(values: FloatArray, seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return of each of K cells its mean over B blocks, that over its error, and the chance of it, (K,).

    The chance is that of so large a statistic in any cell if the signs of blocks were random.

    Args:
        values: Of each cell in each block, (B, K).
        seed: Of the signs.
    """
    blocks = len(values)
    mean, own = values.mean(axis=0), values.var(axis=0, ddof=1)
    error = np.sqrt((own + np.median(own) + 1e-30) / (2 * blocks))
    statistic = mean / error
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(FLIPS, blocks))
    square = (values**2).mean(axis=0)
    flipped = signs @ values / blocks
    spread = np.fmax(square - flipped**2, 0.0) * blocks / (blocks - 1)
    null = np.abs(flipped) / np.sqrt(
        (spread + np.median(spread, axis=1, keepdims=True) + 1e-30) / (2 * blocks)
    )
    largest = np.sort(null.max(axis=1))
    smaller = np.searchsorted(largest, AS_LARGE * np.abs(statistic))
    return mean, statistic, (1.0 + FLIPS - smaller) / (FLIPS + 1)


def _channels(
    evidence: Evidence, residual: FloatArray, excess: FloatArray, bins: IntArray
) -> tuple[ChannelGap, ...]:
    third = np.concatenate([np.arange(p.frames) * 3 // p.frames for p in evidence.parts])

    def over(groups: IntArray, count: int) -> list[FloatArray]:
        """Energy over expectation of each of so many groups of frames."""
        pairs = [
            ((residual**2)[groups == i], evidence.frame_count[groups == i]) for i in range(count)
        ]
        return [mean_energy(energy.sum(axis=0), frames.sum(axis=0)) for energy, frames in pairs]

    bands, thirds = _bands(evidence, residual).T, np.transpose(over(third, 3))
    phases = np.transpose(over(bins, PHASE_BINS))
    return tuple(
        ChannelGap(
            c.name, c.joint, c.stage, float(excess[i]),
            tuple(bands[i].tolist()), tuple(thirds[i].tolist()), tuple(phases[i].tolist()),
        )
        for i, c in enumerate(evidence.simulator.channels)
    )  # fmt: skip


def _bands(evidence: Evidence, residual: FloatArray) -> FloatArray:
    """Shares of each channel's energy in four bands of the cycle's frequency, (4, C)."""
    total = np.zeros((4, residual.shape[1]))
    at = 0
    for part in evidence.parts:
        rows = residual[at : at + part.frames]
        at += part.frames
        cycle = part.observation.cycle
        if not np.isfinite(cycle).all() or abs(cycle[-1] - cycle[0]) < 1.0:
            continue
        per_frame = abs(cycle[-1] - cycle[0]) / (part.frames - 1)
        harmonic = np.fft.rfftfreq(part.frames) / per_frame
        power = np.abs(np.fft.rfft(rows, axis=0)) ** 2
        edges = (0.0, 0.5, 3.5, 10.5, np.inf)
        for i in range(4):
            on = (harmonic >= edges[i]) & (harmonic < edges[i + 1])
            total[i] += power[on].sum(axis=0)
    whole = total.sum(axis=0)
    return mean_energy(total, whole)


def clearest_there(causes: Sequence[tuple[str, Sequence[str]]], remaining: Where) -> Iterator[str]:
    """Say for each joint of a named cause if what remains is clearest there, one sentence each.

    Where a cause is all that is new, what is left of its own joint's channels is no clearer than the
    rest. In 106 cases of 19 realities (2026-11-26, labels open) it was clearest there for four of seven
    causes outside the catalogue that had been called another cause, for two pairs of which one cause was
    missed, and for one of the answers that were whole, which was ``unexplained``.

    Args:
        causes: Name and joints of each.
        remaining: What they leave.
    """
    joints = {joint: name for name, places in reversed(causes) for joint in places}
    elsewhere = max(
        (abs(one.statistic) for one in remaining.cells if one.joint not in joints), default=0.0
    )
    for joint, name in joints.items():
        here = [one for one in remaining.cells if one.joint == joint]
        clearest = max(here, key=lambda one: abs(one.statistic), default=None)
        if clearest is None or abs(clearest.statistic) < max(CLEAR_CELL, CLEARER * elsewhere):
            continue
        size = abs(clearest.statistic)
        yield (
            f"what remains is clearest at {joint} ({clearest.channel}, {size:.0f} standard errors): "
            f"another cause is there, too, or {name} only resembles the true one"
        )
