"""Whether ticks say what a log holds, to the bit: outputs as a table of bytes beside the recorded one.

What comes out is what ``says_the_same`` tells of each tick. Where it is not certain, it says no; then each
tick is to be asked by itself.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray, IntArray
from record.log.blocks.message_form import Columns, FieldPlace
from record.log.cdr import HEADER
from record.log.estimate_message import (
    EstimateFields,
    estimate_columns,
)
from record.log.tick_message import OUTPUT_PLACES

_CODES = ("mode", "stop_reason")
_TEXTS = ("support_reason", "traction_reason")
NOTHING_BEHIND = 4  # bytes of the length of a sequence of none


# Fields of messages of B ticks, by name: numbers with a row for each, or texts.
Laid = Mapping[str, NDArray[Any] | Sequence[str]]


class OutputFields(Protocol):
    """Outputs of B ticks of one robot, but for estimates, each in all of them at once."""

    def __len__(self) -> int:
        """B."""
        ...

    @property
    def faulty(self) -> BoolArray:
        """Which ticks have a fault, (B,)."""
        ...

    def column(self, name: str) -> NDArray[Any]:
        """Return an output in numbers, (B, ...); its names are places in a ``Tick``; codes of modes."""
        ...

    def texts(self, name: str) -> list[str]:
        """Return a text of each."""
        ...


def lay_outputs(outputs: OutputFields) -> Laid:
    """Return the outputs of ticks as the fields of their messages."""
    fields: dict[str, NDArray[Any] | Sequence[str]] = {
        name: outputs.column(name) for name in _CODES
    }
    for name, where in OUTPUT_PLACES.items():
        fields[name] = outputs.texts(where) if name in _TEXTS else outputs.column(where)
    return fields


def lay_estimates(estimates: EstimateFields) -> Laid:
    """Return the estimates of ticks, one each, as the fields of their messages."""
    count = len(estimates)
    return {
        f"estimate.0.{name}": values if isinstance(values, list) else values.reshape(count, -1)
        for name, values in estimate_columns(estimates)
    }


def same_outputs(recorded: Columns, outputs: Laid, at: IntArray) -> BoolArray:
    """Which ticks are certainly as recorded, but for their faults and estimates, (B,).

    Args:
        recorded: Their messages.
        outputs: Today's of those and other ticks, from the inputs in the messages.
        at: Which of these, (B,).
    """
    form = recorded.form
    if form.counts["faults"]:
        return np.zeros(len(recorded), dtype=bool)
    expected = _Expected(recorded, outputs, at)
    end = len(HEADER) + form.begins["faults"] + NOTHING_BEHIND
    begin, codes = form.places["joints_t_ns"].at, [form.places[name].at for name in _CODES]
    there, here = recorded.table, expected.table
    same: BoolArray = (
        expected.same
        & (there[:, begin:end] == here[:, begin:end]).all(axis=1)
        & (there[:, codes] == here[:, codes]).all(axis=1)
    )
    return same


def same_estimates(recorded: Columns, estimates: Laid, at: IntArray) -> BoolArray:
    """Which estimates are certainly as recorded, (B,).

    Args:
        recorded: Messages of ticks.
        estimates: Today's of those and other ticks.
        at: Which of these, (B,).
    """
    form = recorded.form
    if form.counts["estimate"] != 1:
        return np.zeros(len(recorded), dtype=bool)
    expected = _Expected(recorded, estimates, at)
    begin = len(HEADER) + form.begins["estimate"]
    same: BoolArray = expected.same & (recorded.table[:, begin:] == expected.table[:, begin:]).all(
        axis=1
    )
    return same


class _Expected:
    """Messages of a form as they should be, a row each.

    Args:
        recorded: The messages.
        fields: Of those and other messages.
        at: Which of these.
    """

    def __init__(self, recorded: Columns, fields: Laid, at: IntArray) -> None:
        self._form = recorded.form
        count, size = len(recorded), recorded.form.size
        self.table = np.zeros((count, size), np.uint8)
        marked, marks = recorded.form.marks
        self.table[:, marked] = marks
        self.same = np.ones(count, dtype=bool)
        for name, values in fields.items():
            if isinstance(values, np.ndarray):
                self._numbers(name, values[at])
            else:
                self._texts(name, [values[k] for k in at.tolist()])

    def _numbers(self, name: str, values: NDArray[Any]) -> None:
        """Lay numbers, a row each."""
        place = self._form.places[name]
        if place.kind is None or values.size != len(self.table) * abs(place.numbers):
            self.same[:] = False
        elif values.size:
            rows = np.ascontiguousarray(values.reshape(len(self.table), -1), place.kind)
            self._lay(place, rows.view(np.uint8))

    def _texts(self, name: str, values: Sequence[str]) -> None:
        """Lay a text each."""
        place = self._form.places[name]
        encoded = [text.encode() + b"\0" for text in values]
        fits = np.array([len(text) == place.numbers for text in encoded])
        self.same &= fits
        if fits.all():
            rows = np.frombuffer(b"".join(encoded), np.uint8).reshape(len(encoded), -1)
            self._lay(place, rows)

    def _lay(self, place: FieldPlace, rows: NDArray[np.uint8]) -> None:
        self.table[:, place.at : place.at + rows.shape[1]] = rows
