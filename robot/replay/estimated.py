"""Estimates of stepped ticks against the recorded ones, where the controller was stepped without them.

No command depends on an estimate, so a block of ticks can be estimated after it was stepped: at once, and
without an object for each tick.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.estimator.block.columns import BlockFields
from model.values.arrays import BoolArray
from model.values.estimate import Estimate, Health
from model.values.tick import Tick
from record.log.blocks.tick_outputs import lay_estimates, same_estimates
from record.log.estimate_message import EstimateFields, ListedEstimates
from record.log.tick_message import says_the_same
from robot.control.estimator_block import StageBlock
from robot.control.tick_estimator import SingleTick, TickEstimator
from robot.replay.blocks import SteppedBlock
from robot.replay.outputs import one_after_the_other

Part = StageBlock | SingleTick


class EstimatedTicks:
    """Estimates of ticks in a row, of blocks and of single ticks.

    Args:
        parts: At least one.
    """

    def __init__(self, parts: Sequence[Part]) -> None:
        self._fields: list[EstimateFields] = []
        self._estimates: list[Callable[[int], Estimate]] = []  # of each of these, one by its number
        for _, own in groupby(parts, type):
            singles, blocks = list[Estimate](), list[StageBlock]()
            for part in own:
                if isinstance(part, SingleTick):
                    singles.append(part.estimate)
                else:
                    blocks.append(part)
            if singles:
                self._fields.append(ListedEstimates(singles))
                self._estimates.append(singles.__getitem__)
            self._fields += [BlockFields(part.block) for part in blocks]
            self._estimates += [part.estimate for part in blocks]

    def __len__(self) -> int:
        return sum(map(len, self._fields))

    def column(self, name: str) -> NDArray[Any]:
        """Return a field in numbers, (B, ...); its names are those of ``Estimate``."""
        return one_after_the_other([of.column(name) for of in self._fields])

    def texts(self, name: str) -> list[str]:
        """Return a text of each."""
        return [text for of in self._fields for text in of.texts(name)]

    def healths(self) -> list[Health]:
        """Return the verdict in each."""
        return [health for of in self._fields for health in of.healths()]

    def estimate(self, place: int) -> Estimate:
        """Return one by itself."""
        for of, estimate in zip(self._fields, self._estimates, strict=True):
            if place < len(of):
                return estimate(place)
            place -= len(of)
        raise IndexError(place)


class ComparedBlock:
    """A block of stepped ticks with their estimates, beside what the log says.

    Args:
        block: The ticks.
        estimator: It remembers the tick before; None where none is wished.
    """

    def __init__(self, block: SteppedBlock, estimator: TickEstimator | None) -> None:
        self.block = block
        self._made: EstimatedTicks | None = None
        if estimator is not None:
            ticks = (part.sensed for part in block.parts)
            self._made = EstimatedTicks([made for own in ticks for made in estimator.through(own)])

    @property
    def newest(self) -> Estimate | None:
        """The last estimate."""
        return None if self._made is None else self._made.estimate(len(self.block) - 1)

    def tick(self, place: int) -> Tick:
        """Return today's tick."""
        tick = self.block.tick(place)
        return tick if self._made is None else replace(tick, estimate=self._made.estimate(place))

    def same(self) -> BoolArray:
        """Which ticks are as recorded in every bit, (B,)."""
        block, count = self.block, len(self.block)
        same, alike = block.same(), np.zeros(count, dtype=bool)
        estimates = None if self._made is None else lay_estimates(self._made)
        for places, columns in block.groups:
            at = np.array(places)
            if estimates is None:
                alike[at[at < count]] = not columns.form.counts["estimate"]
            elif at[-1] < count:
                alike[at] = same_estimates(columns, estimates, at)
        for place in np.flatnonzero(same & ~alike).tolist():
            message, end = block.messages[place], block.ends[place]
            same[place] = says_the_same(self.tick(place), message.data, end, message.layout)
        return same
