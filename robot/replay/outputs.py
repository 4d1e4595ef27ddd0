"""Today's ticks of a replay: those that were stepped one by one, and those of a walk in rows."""

from collections.abc import Sequence
from operator import attrgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray
from model.values.tick import Tick
from model.values.tick_rows import SensedRows
from record.log.blocks.tick_outputs import OutputFields
from record.log.estimate_message import one_behind_the_other
from record.log.reader import TopicMessage
from record.log.tick_message import decode_inputs
from robot.replay.rows.walked import WalkedRows


class SteppedPart(OutputFields, Protocol):
    """Ticks in a row."""

    def tick(self, k: int) -> Tick:
        """Return one of them."""
        ...

    def time_ns(self, k: int) -> int:
        """Return the time of one of them."""
        ...

    @property
    def sensed(self) -> SensedRows:
        """What was sensed in them."""
        ...


class SingleSteps:
    """Ticks that were stepped one by one."""

    def __init__(self) -> None:
        self._ticks: list[Tick] = []

    def __len__(self) -> int:
        return len(self._ticks)

    def add(self, tick: Tick) -> None:
        """Add the next one."""
        self._ticks.append(tick)

    def tick(self, k: int) -> Tick:
        """As in ``SteppedPart``."""
        return self._ticks[k]

    def time_ns(self, k: int) -> int:
        """As in ``SteppedPart``."""
        return self._ticks[k].t_ns

    @property
    def sensed(self) -> SensedRows:
        """As in ``SteppedPart``."""
        return SensedRows.stacked([tick.sensed for tick in self._ticks])

    @property
    def faulty(self) -> BoolArray:
        """As in ``OutputFields``."""
        return np.array([bool(tick.faults) for tick in self._ticks])

    def column(self, name: str) -> NDArray[Any]:
        """As in ``OutputFields``."""
        if name in {"mode", "stop_reason"}:
            name = f"{name}.value"
        values = list(map(attrgetter(name), self._ticks))
        return one_behind_the_other(values).reshape(len(values), *np.shape(values[0]))

    def texts(self, name: str) -> list[str]:
        """As in ``OutputFields``."""
        return list(map(attrgetter(name), self._ticks))


class WalkedPart:
    """Ticks of a walk in which nothing happens.

    Args:
        walked: The ticks.
        messages: Their messages.
    """

    def __init__(self, walked: WalkedRows, messages: Sequence[TopicMessage]) -> None:
        self._walked, self._messages = walked, messages

    def __len__(self) -> int:
        return len(self._walked)

    def tick(self, k: int) -> Tick:
        """As in ``SteppedPart``."""
        message = self._messages[k]
        return self._walked.tick(k, decode_inputs(message.data, message.layout).inputs)

    def time_ns(self, k: int) -> int:
        """As in ``SteppedPart``."""
        return int(self._walked.rows.t_ns[k])

    @property
    def sensed(self) -> SensedRows:
        """As in ``SteppedPart``."""
        return self._walked.sensed

    @property
    def faulty(self) -> BoolArray:
        """As in ``OutputFields``."""
        return np.zeros(len(self), dtype=bool)

    def column(self, name: str) -> NDArray[Any]:
        """As in ``OutputFields``."""
        return self._walked.column(name)

    def texts(self, name: str) -> list[str]:
        """As in ``OutputFields``."""
        return self._walked.texts(name)


class SteppedOutputs:
    """Outputs of ticks in a row.

    Args:
        parts: At least one.
    """

    def __init__(self, parts: Sequence[SteppedPart]) -> None:
        self._parts = parts

    def __len__(self) -> int:
        return sum(map(len, self._parts))

    @property
    def faulty(self) -> BoolArray:
        """As in ``OutputFields``."""
        return one_after_the_other([part.faulty for part in self._parts])

    def column(self, name: str) -> NDArray[Any]:
        """As in ``OutputFields``."""
        return one_after_the_other([part.column(name) for part in self._parts])

    def texts(self, name: str) -> list[str]:
        """As in ``OutputFields``."""
        return [text for part in self._parts for text in part.texts(name)]


def one_after_the_other(columns: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Columns of parts, at least one, as that of the whole."""
    return columns[0] if len(columns) == 1 else np.concatenate(columns)
