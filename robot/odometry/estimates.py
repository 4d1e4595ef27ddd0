"""Estimates of many ticks as columns: of an hour they take half a gigabyte, and as objects four."""

from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from model.estimator.block.columns import BlockFields
from model.estimator.block.run import EstimatedBlock
from model.values.arrays import FloatArray, readonly
from model.values.estimate import Estimate, Health
from record.growing_array import GrowingTable
from record.log.estimate_message import HEALTHS, EstimateFields, ListedEstimates

BLOCK = 128  # rows
HEALTH, TEXTS = "health", ("reason", "remark")
NAMES = tuple(field.name for field in fields(Estimate))
REAL = {field.name for field in fields(Estimate) if field.type is float}
Columns = dict[str, NDArray[Any]]


class EstimateSeries(Sequence[Estimate]):
    """Estimates of T ticks; one that is asked for is put together from the columns.

    Args:
        columns: Each field of ``Estimate`` in all ticks, (T, ...); health and texts by their numbers.
        texts: The texts that are numbered.

    Attributes:
        texts: The same.
    """

    def __init__(self, columns: Columns, texts: Sequence[str]) -> None:
        self._columns, self.texts = columns, texts

    @classmethod
    def of(cls, estimates: Iterable[Estimate]) -> "EstimateSeries":
        """Return estimates as columns.

        Args:
            estimates: At least one, all of the same robot.
        """
        made = EstimateColumns()
        for estimate in estimates:
            made.add(estimate)
        return made.estimates()

    def __len__(self) -> int:
        return len(self._columns["t_ns"])

    @overload
    def __getitem__(self, at: int) -> Estimate: ...
    @overload
    def __getitem__(self, at: slice) -> "EstimateSeries": ...
    def __getitem__(self, at: int | slice) -> "Estimate | EstimateSeries":
        if isinstance(at, slice):
            return EstimateSeries({name: of[at] for name, of in self._columns.items()}, self.texts)
        values: dict[str, Any] = {
            name: of[at] if of.ndim > 1 else of[at].item() for name, of in self._columns.items()
        }
        values[HEALTH] = HEALTHS[values[HEALTH]]
        for name in TEXTS:
            values[name] = self.texts[values[name]]
        return Estimate(**values)

    def column(self, name: str) -> FloatArray:
        """Return a field in numbers of every tick, (T, ...).

        Args:
            name: Of the field; not that of the health or of a text.
        """
        if name == HEALTH or name in TEXTS:
            raise KeyError(name)
        return self._columns[name].astype(np.float64, copy=False)

    def codes(self, name: str) -> NDArray[Any]:
        """Return a field of every tick as it is kept, (T, ...): health and texts by their numbers."""
        return self._columns[name]

    @property
    def healths(self) -> list[Health]:
        """The verdict in every tick."""
        return [HEALTHS[code] for code in self._columns[HEALTH].tolist()]

    @property
    def reasons(self) -> list[str]:
        """Why it is not ok, in every tick."""
        return self._text("reason")

    @property
    def remarks(self) -> list[str]:
        """What does not agree with the robot file or the ground, in every tick."""
        return self._text("remark")

    def _text(self, name: str) -> list[str]:
        return [self.texts[code] for code in self._columns[name].tolist()]


class EstimateColumns:
    """Columns that grow by an estimate at a time; a block of them is joined at once."""

    def __init__(self) -> None:
        self._codes: dict[str, int] = {}
        self._full = GrowingTable()
        self._block: list[Estimate] = []

    def __len__(self) -> int:
        return len(self._full) + len(self._block)

    def add(self, estimate: Estimate) -> None:
        """Add the estimate of the next tick."""
        self._block.append(estimate)
        if len(self._block) == BLOCK:
            self._end_block()

    def add_block(self, block: EstimatedBlock) -> None:
        """Add the estimates of the ticks of a block."""
        self._end_block()
        self._take(BlockFields(block))

    def extend(self, more: EstimateSeries) -> None:
        """Add the estimates of the next ticks."""
        self._end_block()
        codes = np.array([self._code(text) for text in more.texts], dtype=np.int64)
        rows = {name: more.codes(name) for name in NAMES}
        self._full.extend(rows | {name: codes[rows[name]] for name in TEXTS})

    def estimates(self) -> EstimateSeries:
        """Return all estimates so far, at least one."""
        self._end_block()
        columns = {name: readonly(values) for name, values in self._full.arrays().items()}
        return EstimateSeries(columns, tuple(self._codes))

    def _code(self, text: str) -> int:
        return self._codes.setdefault(text, len(self._codes))

    def _end_block(self) -> None:
        if self._block:
            self._take(ListedEstimates(self._block))
        self._block = []

    def _take(self, of: EstimateFields) -> None:
        """Add the fields of ticks in a row; texts are numbered in the order in which they are met."""
        met = zip(*(of.texts(name) for name in TEXTS), strict=True)
        codes = np.array([[self._code(text) for text in texts] for texts in met], dtype=np.int64)
        rows: Columns = dict(zip(TEXTS, codes.T, strict=True))
        rows[HEALTH] = np.array([HEALTHS.index(one) for one in of.healths()], dtype=np.int64)
        for name in NAMES:
            if name not in rows:
                values = of.column(name)
                rows[name] = values.astype(np.float64, copy=False) if name in REAL else values
        self._full.extend(rows)
