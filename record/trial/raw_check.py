"""What is odd about a table before it is mapped: signs hidden in a bit, numbers that wrap."""

from collections.abc import Sequence

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from record.trial.column_map import Source
from record.trial.table_check import TableFinding
from record.trial.table_file import DataTable

SIGN_BITS = (*range(7, 16), 31)
WORD_BITS = (8, 16, 32)
FEWEST = 3  # on either side, or it is chance
SIZE_SHARE = 0.5  # of the bit's value, that sizes stay below


def raw_findings(table: DataTable, sources: Sequence[Source]) -> list[TableFinding]:
    """Look at the whole numbers of a table."""
    findings: list[TableFinding] = []
    for column in table.columns:
        given = column.values
        if given.dtype.kind not in "fi":
            continue
        values = given[np.isfinite(given)]
        if len(values) and (values >= 0).all() and (values == np.round(values)).all():
            findings += _hidden_sign(column.name, values, sources)
    return findings


def _hidden_sign(name: str, values: FloatArray, sources: Sequence[Source]) -> list[TableFinding]:
    """Look for numbers whose sign is a bit, then for such as wrap; the first that fits is listed."""
    read = next((one for one in sources if one.theirs == name), Source("", ""))
    for bit in SIGN_BITS:
        level = 2.0**bit
        high = values >= level
        sizes = np.where(high, values - level, values)
        if _both_signs(high, sizes, SIZE_SHARE * level):
            taken = "read so" if read.sign_bit == bit else f"map it with sign_bit = {bit}"
            return [_wrap(name, high, f"the sign is in bit {bit} ({taken})")]
    for bits in WORD_BITS:
        level = 2.0**bits
        high = values >= 0.5 * level
        sizes = np.where(high, level - values, values)
        if values.max() < level and _both_signs(high, sizes, 0.25 * SIZE_SHARE * level):
            taken = "read so" if read.signed_bits == bits else f"map it with signed_bits = {bits}"
            return [_wrap(name, high, f"negative numbers wrap at {level:.0f} ({taken})")]
    return []


def _both_signs(high: BoolArray, sizes: FloatArray, largest: float) -> bool:
    return bool(min(high.sum(), (~high).sum()) >= FEWEST and sizes.max() <= largest)


def _wrap(name: str, high: BoolArray, words: str) -> TableFinding:
    return TableFinding(
        "wrap", name, int(high.sum()), int(np.argmax(high)) + 1, f"unsigned, {words}"
    )
