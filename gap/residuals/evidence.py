"""Whitened residuals of all parts side by side, and their score in blocks.

The score of a block and channel is a quarter-tailed log likelihood: its energy where it is what noise
gives, and its logarithm where it is far more, so that a large gap that no cause closes does not drown
what the candidates differ in.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gap.constants import NO_ANSWER, TAIL, WHOLE_SHARE
from gap.interfaces import Cause, Drive, reach_of
from gap.residuals.floor import Floor
from gap.residuals.parts import TrialPart, block_starts, folds_of
from gap.residuals.pool import PredictionRequest
from gap.residuals.predictions import Misfit, Predictor
from gap.residuals.whitening import Whitener, make_whitener
from model.values.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Evidence(Misfit):
    """Parts of trials under one drive, F frames in all.

    Attributes:
        whiteners: One a part.
        starts: First frame of each of B blocks, counted over all parts.
        folds: Fold of each block, (B,).
        block_part: Part of each block, (B,).
    """

    parts: tuple[TrialPart, ...]
    drive: Drive
    floor: Floor
    whiteners: tuple[Whitener, ...]
    starts: IntArray
    folds: IntArray
    block_part: IntArray

    @cached_property
    def frame_count(self) -> FloatArray:
        """Independent frames that each frame and channel counts as, (F, C)."""
        return np.concatenate([w.count for w in self.whiteners])

    @cached_property
    def count(self) -> FloatArray:
        """Independent frames of each block and channel, (B, C)."""
        return self.per_block(self.frame_count)

    @property
    def reach_m(self) -> tuple[float, float]:
        """Between which places along the world's x the machine touched its world; NaN if unknown."""
        return reach_of([part.observation for part in self.parts])

    @cached_property
    def block_of_frame(self) -> IntArray:
        """Block of each frame, (F,)."""
        frames = sum(part.frames for part in self.parts)
        return np.asarray(np.searchsorted(self.starts, np.arange(frames), side="right") - 1)

    @cached_property
    def base(self) -> FloatArray:
        """Whitened residual of the unchanged simulator, (F, C)."""
        return self.residuals([()])[0]

    @cached_property
    def base_score(self) -> FloatArray:
        """Misfit of each block and channel of the unchanged simulator in nats, (B, C)."""
        return self.score(self.base)

    @cached_property
    def base_weights(self) -> FloatArray:
        """Weight of each frame by what the unchanged simulator leaves, (F, C)."""
        return self.weights(self.base)

    def per_block(self, values: FloatArray) -> FloatArray:
        """Sum over the frames of each block, (F, C) to (B, C)."""
        return np.asarray(np.add.reduceat(values, self.starts, axis=0))

    def predictions(self, sets: Sequence[tuple[Cause, ...]]) -> list[list[FloatArray]]:
        """Predict every part with each set of causes."""
        requests = [
            PredictionRequest(part.trial, causes, self.drive)
            for causes in sets
            for part in self.parts
        ]
        predicted = self.predictor.predict(requests)
        n = len(self.parts)
        return [
            [part.cut(one) for part, one in zip(self.parts, predicted[i : i + n], strict=True)]
            for i in range(0, len(predicted), n)
        ]

    def residuals(self, sets: Sequence[tuple[Cause, ...]]) -> list[FloatArray]:
        """Whitened residual with each set of causes, (F, C); where one has no answer, it pays for that."""
        out = []
        for predicted in self.predictions(sets):
            rows = []
            for part, whitener, one in zip(self.parts, self.whiteners, predicted, strict=True):
                error = part.observation.values - one
                known = np.isfinite(one)
                if not known.all() and (lost := ~known & (whitener.gain > 0)).any():
                    before = part.observation.values - self._standing(part)
                    error = np.where(lost, before + self._cost_of_none(before, whitener), error)
                rows.append(whitener.whiten(error))
            out.append(np.concatenate(rows))
        return out

    def _cost_of_none(self, before: FloatArray, whitener: Whitener) -> FloatArray:
        """What is added to the error of the unchanged simulator where a candidate broke it, (F, C)."""
        away = np.where(before >= whitener.expected, 1.0, -1.0)
        return np.asarray(away * NO_ANSWER * self.floor.sigma)

    def _standing(self, part: TrialPart) -> FloatArray:
        return part.cut(self.predictor.predict([PredictionRequest(part.trial, (), self.drive)])[0])

    def score(self, residual: FloatArray) -> FloatArray:
        """Misfit of each block and channel in nats, (B, C): less is better."""
        safe = np.fmax(self.count, 1e-9)
        nats = 0.5 * TAIL * safe * np.log1p(self.per_block(residual**2) / (TAIL * safe))
        return np.where(self.count > 0, nats, 0.0)

    def nats(self, sets: Sequence[tuple[Cause, ...]]) -> list[float]:
        """Misfit of all blocks and channels together with each set of causes."""
        return [float(self.score(one).sum()) for one in self.residuals(sets)]

    def most_gained(self, change: FloatArray) -> float:
        """Most nats that a residual, whatever it is, gains when a change, (F, C), is subtracted from it.

        Of a block and channel whose residual has length r, in units in which its score is
        n ln(1 + r^2) / 2, a change of length d gains most where r (r - d) = 1, which is n asinh(d / 2).
        """
        free = TAIL * np.fmax(self.count, 1e-9)
        length = np.sqrt(self.per_block(change**2) / free)
        return float((free * np.arcsinh(0.5 * length))[self.count > 0].sum())

    def weights(self, residual: FloatArray) -> FloatArray:
        """Weight of each frame in a quadratic that is tangent to the score, (F, C)."""
        energy = self.per_block(residual**2)
        weight = 1.0 / (1.0 + energy / (TAIL * np.fmax(self.count, 1e-9)))
        return np.asarray(weight[self.block_of_frame])

    def excess(self, residual: FloatArray) -> FloatArray:
        """Energy over expectation of each channel, (C,); NaN where nothing was compared."""
        return mean_energy((residual**2).sum(axis=0), self.count.sum(axis=0))

    def mean_excess(self, residual: FloatArray) -> float:
        """Energy over expectation of all channels together."""
        return float((residual**2).sum() / self.count.sum())


def mean_energy(energy: FloatArray, count: FloatArray) -> FloatArray:
    """Return energies, or other sums, over so many independent frames; NaN where there is none."""
    return np.where(count > 0, energy / np.where(count > 0, count, 1.0), np.nan)


def make_evidence(
    predictor: Predictor, parts: Sequence[TrialPart], drive: Drive, floor: Floor
) -> Evidence:
    """Whiten parts under a drive."""
    base = predictor.predict([PredictionRequest(part.trial, (), drive) for part in parts])
    whiteners = tuple(
        make_whitener(part, floor, part.cut(one)) for part, one in zip(parts, base, strict=True)
    )
    return evidence_of(predictor, parts, drive, floor, whiteners)


def evidence_of(
    predictor: Predictor,
    parts: Sequence[TrialPart],
    drive: Drive,
    floor: Floor,
    whiteners: Sequence[Whitener],
) -> Evidence:
    """Take parts with whiteners of their own."""
    blocks = [block_starts(part.observation) for part in parts]
    offsets = np.concatenate([[0], np.cumsum([part.frames for part in parts])[:-1]])
    return Evidence(
        parts=tuple(parts),
        drive=drive,
        predictor=predictor,
        floor=floor,
        whiteners=tuple(whiteners),
        starts=np.concatenate([at + o for at, o in zip(blocks, offsets, strict=True)]).astype(
            np.int64
        ),
        folds=folds_of(parts, blocks),
        block_part=np.repeat(np.arange(len(parts)), [len(at) for at in blocks]),
    )


def errors(
    predictor: Predictor, parts: Sequence[TrialPart], drive: Drive, causes: tuple[Cause, ...] = ()
) -> list[FloatArray]:
    """Measured minus predicted, by default as the simulator stands, (F, C) a part; NaN where unused."""
    base = predictor.predict([PredictionRequest(part.trial, causes, drive) for part in parts])
    return [
        np.where(part.observation.weight > 0, part.observation.values - part.cut(one), np.nan)
        for part, one in zip(parts, base, strict=True)
    ]


def local_drive(predictor: Predictor, parts: Sequence[TrialPart]) -> Drive:
    """Measured inputs, unless the simulator is one piece and then has no answer on most channels."""
    measured, command = (_answers(predictor, parts[:1], d) for d in (Drive.MEASURED, Drive.COMMAND))
    return Drive.MEASURED if measured >= WHOLE_SHARE * command else Drive.COMMAND


def judging_drive(
    predictor: Predictor, parts: Sequence[TrialPart], local: Callable[[], Drive]
) -> Drive:
    """Commands alone, end to end, unless they were not recorded and most channels have no answer then.

    Args:
        predictor: Predicts the parts.
        parts: All that is compared: what is judged, and the references that say what is expected.
        local: Returns what feeds the stages otherwise.
    """
    for part in parts:
        if np.isfinite(predictor.trials[part.trial].command_rad).any(axis=0).all():
            continue
        measured, command = (_answers(predictor, [part], d) for d in (local(), Drive.COMMAND))
        if command < WHOLE_SHARE * measured:
            return local()
    return Drive.COMMAND


def _answers(predictor: Predictor, parts: Sequence[TrialPart], drive: Drive) -> int:
    """How many channels a drive has an answer for, of those that were measured."""
    left = errors(predictor, parts, drive)
    return sum(int(np.isfinite(one).any(axis=0).sum()) for one in left)
