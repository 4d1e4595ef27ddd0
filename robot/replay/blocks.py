"""Recorded inputs through a controller, a block of ticks at a time, and what the log says of each.

Ticks of one form are read as columns, and compared as bytes beside each other. Those of a walk in which
nothing happens are stepped in rows; all others one by one. What comes out is what ``step_through`` makes.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.values.arrays import BoolArray
from model.values.input_rows import InputRows
from model.values.tick import Tick
from record.log.blocks.input_columns import input_rows
from record.log.blocks.message_form import Columns
from record.log.blocks.tick_forms import FormBook
from record.log.blocks.tick_outputs import lay_outputs, same_outputs
from record.log.reader import TopicMessage, sound
from record.log.tick_message import LAYOUT, TickInputs, decode_inputs, says_the_same
from robot.control.controller import Controller
from robot.control.state import ControllerState
from robot.replay.outputs import SingleSteps, SteppedOutputs, SteppedPart, WalkedPart
from robot.replay.rows.walker import RowWalker, row_walker
from robot.replay.step_through import gap_words, step_recorded

BLOCK_TICKS = (
    256  # enough that numpy's overhead does not count; what they hold stays near the processor
)


@dataclass(frozen=True, slots=True, eq=False)
class SteppedBlock:
    """Some ticks of a log, and today's, without estimates.

    Attributes:
        path: The log.
        messages: As recorded.
        parts: Today's, in order.
        groups: Messages of one form, and which they are.
        ends: Where the inputs end in each message.
        state: Of the controller after the last of them.
    """

    path: Path
    messages: list[TopicMessage]
    parts: list[SteppedPart]
    groups: list[tuple[list[int], Columns]]
    ends: list[int]
    state: ControllerState

    def __len__(self) -> int:
        return len(self.ends)

    @property
    def times_ns(self) -> tuple[int, int]:
        """Of the first tick and of the last."""
        return self.time_ns(0), self.time_ns(len(self) - 1)

    def time_ns(self, place: int) -> int:
        """Return the time of a tick."""
        part, k = self._part(place)
        return part.time_ns(k)

    def tick(self, place: int) -> Tick:
        """Return today's tick."""
        part, k = self._part(place)
        return part.tick(k)

    def _part(self, place: int) -> tuple[SteppedPart, int]:
        """The part in which a tick is, and its number there."""
        for part in self.parts:
            if place < len(part):
                return part, place
            place -= len(part)
        raise IndexError(place)

    def recorded(self, place: int) -> TickInputs:
        """Return the inputs of a tick, from its message.

        Raises:
            RecordError: It is damaged.
        """
        message = self.messages[place]
        with sound(self.path, message):
            return decode_inputs(message.data, message.layout)

    def same(self) -> BoolArray:
        """Which ticks are as recorded in every bit, but for estimates, (B,)."""
        count, made = len(self), SteppedOutputs(self.parts)
        same = np.zeros(count, dtype=bool)
        outputs = lay_outputs(made)
        for places, columns in self.groups:
            if places[-1] < count:  # else a gap ended the replay in the middle of the block
                at = np.array(places)
                same[at] = same_outputs(columns, outputs, at)
        same &= ~made.faulty
        for place in np.flatnonzero(~same).tolist():
            message, end = self.messages[place], self.ends[place]
            same[place] = says_the_same(
                self.tick(place), message.data, end, message.layout, estimate=False
            )
        return same


def step_in_blocks(
    path: Path,
    messages: Iterable[TopicMessage],
    controller: Controller,
    notes: list[str],
    state: ControllerState | None = None,
    first: int = 0,
) -> Iterator[SteppedBlock]:
    """Step a controller without an estimator through recorded inputs.

    Args:
        path: The log.
        messages: Its ticks as messages, from the first one on.
        controller: The controller.
        notes: Gets a line where the log has a gap; the replay ends there.
        state: Of the controller before the first of them; as it begins if None.
        first: Number of that tick.

    Yields:
        Blocks of at least one tick.

    Raises:
        RecordError: A tick is damaged.
    """
    state = controller.initial() if state is None else state
    reader, walker = _Reader(messages, controller), row_walker(controller)
    index = first
    while block := reader.block():
        steps = _Steps(path, controller, walker, block, state)
        for message in steps.left():
            with sound(path, message):
                inputs = decode_inputs(message.data, message.layout)
            if inputs.index != index + steps.count:
                notes.append(gap_words(index + steps.count, inputs.index))
                break
            steps.step(message, inputs)
        state, index = steps.state, index + steps.count
        if steps.count:
            yield steps.stepped()
        if steps.count < len(block.messages):
            return


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """Messages, those of each form, and their inputs if any are of a usual one."""

    messages: list[TopicMessage]
    groups: list[tuple[list[int], Columns]]
    inputs: InputRows | None


class _Steps:
    """Steps through a block.

    Args:
        path: The log.
        controller: The controller.
        walker: Steps it in rows, if that can be.
        block: The block.
        state: Before it.

    Attributes:
        state: After what has been stepped.
        count: How many ticks that are.
    """

    def __init__(
        self,
        path: Path,
        controller: Controller,
        walker: RowWalker | None,
        block: _Block,
        state: ControllerState,
    ) -> None:
        self._path, self._controller, self._walker = path, controller, walker
        self._block = block
        self.state, self.count = state, 0
        self._parts: list[SteppedPart] = []
        self._alone: SingleSteps | None = None  # the last part, if it is of this kind
        self._ends: list[int] = []

    def left(self) -> Iterator[TopicMessage]:
        """Yield the messages that are to be stepped one by one; all others are done before."""
        messages, inputs = self._block.messages, self._block.inputs
        while self.count < len(messages):
            walked = None
            if inputs is not None and self._walker is not None:
                walked = self._walker.advance(self.state, inputs, self.count)
            if inputs is None or walked is None:
                yield messages[self.count]
                continue
            end = self.count + len(walked)
            self._parts.append(WalkedPart(walked, messages[self.count : end]))
            self._ends += inputs.ends[self.count : end]
            self.state, self.count, self._alone = walked.state, end, None

    def step(self, message: TopicMessage, inputs: TickInputs) -> None:
        """Step by the inputs in the next message."""
        self.state, tick = step_recorded(self._path, message, inputs, self._controller, self.state)
        if self._alone is None:
            self._alone = SingleSteps()
            self._parts.append(self._alone)
        self._alone.add(tick)
        self._ends.append(inputs.end)
        self.count += 1

    def stepped(self) -> SteppedBlock:
        """Return what has been stepped."""
        block = self._block
        return SteppedBlock(
            self._path, block.messages, self._parts, block.groups, self._ends, self.state
        )


class _Reader:
    """Reads messages in blocks.

    What is wrong with the file is said when all that comes before it has been replayed.
    """

    def __init__(self, messages: Iterable[TopicMessage], controller: Controller) -> None:
        self._messages = iter(messages)
        self._machine = controller.config.parameters.names
        self._book = FormBook()
        self._error: RecordError | None = None

    def block(self) -> _Block | None:
        """Return the next block, None at the end.

        Raises:
            RecordError: The file cannot be read any further.
        """
        if self._error is not None:
            raise self._error
        messages: list[TopicMessage] = []
        try:
            messages.extend(islice(self._messages, BLOCK_TICKS))
        except RecordError as error:
            self._error = error
            if not messages:
                raise
        if not messages:
            return None
        groups: list[tuple[list[int], Columns]] = []
        if all(message.layout == LAYOUT for message in messages):
            data = [message.data for message in messages]
            groups = [
                (places.tolist(), columns)
                for places, columns in self._book.groups(data, self._machine)
            ]
        return _Block(messages, groups, input_rows(len(messages), groups))
