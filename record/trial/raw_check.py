"""What is odd about a table before it is mapped: signs hidden in a bit, numbers that wrap, empty rows."""

from collections.abc import Iterable, Sequence

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from record.trial.column_map import Source
from record.trial.table_check import Finding
from record.trial.table_file import Table

SIGN_BITS = (*range(7, 16), 31)
WORD_BITS = (8, 16, 32)
FEWEST = 3  # on either side, or it is chance
SIZE_SHARE = 0.5  # of the bit's value, that sizes stay below


def raw_findings(table: Table, sources: Sequence[Source]) -> list[Finding]:
    """Look at the whole numbers of a table."""
    findings: list[Finding] = []
    for column in table.columns:
        given = column.values
        if given.dtype.kind not in "fi":
            continue
        values = given[np.isfinite(given)]
        if len(values) and (values >= 0).all() and (values == np.round(values)).all():
            findings += _hidden_sign(column.name, values, sources)
    return findings


def _hidden_sign(name: str, values: FloatArray, sources: Sequence[Source]) -> Iterable[Finding]:
    read = next((one for one in sources if one.theirs == name), None)
    for bit in SIGN_BITS:
        level = 2.0**bit
        high = values >= level
        sizes = np.where(high, values - level, values)
        if min(high.sum(), (~high).sum()) < FEWEST or sizes.max() > SIZE_SHARE * level:
            continue
        taken = read is not None and read.sign_bit == bit
        words = "read so" if taken else f"not a number of its own: map it with sign_bit = {bit}"
        yield Finding("wrap", name, int(high.sum()), int(np.argmax(high)) + 1,
                      f"unsigned, the sign is in bit {bit} ({words})")  # fmt: skip
        return
    for bits in WORD_BITS:
        level = 2.0**bits
        high = values >= 0.5 * level
        sizes = np.where(high, level - values, values)
        few = min(high.sum(), (~high).sum()) < FEWEST
        if few or values.max() >= level or sizes.max() > 0.25 * SIZE_SHARE * level:
            continue
        taken = read is not None and read.signed_bits == bits
        words = "read so" if taken else f"map it with signed_bits = {bits}"
        yield Finding("wrap", name, int(high.sum()), int(np.argmax(high)) + 1,
                      f"unsigned, negative numbers wrap at {level:.0f} ({words})")  # fmt: skip
        return


class EmptyRows:
    """Finds rows with a time and nothing that was measured, a column at a time."""

    def __init__(self) -> None:
        self._empty: BoolArray | None = None

    def look_at(self, name: str, values: FloatArray) -> None:
        """Look at one of our columns.

        Args:
            name: Its name.
            values: (T,).
        """
        if name == "time_s" or name.startswith("command_"):
            return
        absent = np.isnan(values)
        self._empty = absent if self._empty is None else self._empty & absent

    def findings(self) -> list[Finding]:
        """Return what was found."""
        if self._empty is None or not self._empty.any():
            return []
        first = int(np.argmax(self._empty)) + 1
        count = int(self._empty.sum())
        return [Finding("empty", "", count, first, "rows in which nothing was measured")]
