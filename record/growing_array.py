"""Arrays that grow by rows in place: of a long log nothing is in memory twice.

Blocks that are kept and put together at the end leave their places behind: the allocator cannot give
back small pieces between others, so that a process stays as large as both together.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

FEWEST_ROWS = 1024
MORE = 0.125  # rows beyond those that are needed, as a share: they are zeroed, and so take memory


class GrowingArray:
    """Rows that are added at the end.

    Args:
        like: An array whose rows are as those to come; none of them is taken.
    """

    def __init__(self, like: NDArray[Any]) -> None:
        self._rows: NDArray[Any] = np.empty((0, *like.shape[1:]), dtype=like.dtype)
        self._count, self._shown = 0, False

    def __len__(self) -> int:
        return self._count

    def extend(self, rows: NDArray[Any]) -> None:
        """Add rows; texts may be longer than those before."""
        if not len(rows):
            return
        kind = np.result_type(self._rows, rows)
        if kind != self._rows.dtype:
            self._rows = self._rows.astype(kind)
        end = self._count + len(rows)
        if end > len(self._rows):
            self._resize(max(FEWEST_ROWS, end + int(MORE * end)))
        self._rows[self._count : end] = rows
        self._count = end

    def array(self) -> NDArray[Any]:
        """Return all rows so far; what is added later is not in it."""
        self._resize(self._count)
        self._shown = True
        return self._rows

    def _resize(self, count: int) -> None:
        if count == len(self._rows):
            return
        if self._shown:  # it is somebody else's, too
            self._rows, self._shown = self._rows[: self._count].copy(), False
        # in place: a long array is moved without a copy
        self._rows.resize((count, *self._rows.shape[1:]), refcheck=False)


class GrowingTable:
    """Columns that grow by as many rows each."""

    def __init__(self) -> None:
        self._columns: dict[str, GrowingArray] = {}

    def __len__(self) -> int:
        return max(map(len, self._columns.values()), default=0)

    def extend(self, rows: Mapping[str, NDArray[Any]]) -> None:
        """Add rows of every column."""
        for name, more in rows.items():
            if name not in self._columns:
                self._columns[name] = GrowingArray(more)
            self._columns[name].extend(more)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return every column with all rows so far."""
        return {name: column.array() for name, column in self._columns.items()}
