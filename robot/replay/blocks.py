"""Recorded inputs through a controller, a block of ticks at a time, and what the log says of each.

Ticks of one form are read as columns, and compared as bytes beside each other. What is unusual is taken
apart, and compared, tick by tick. The steps, and what comes out of them, are those of ``step_through``.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice, takewhile
from pathlib import Path

from model.errors import RecordError
from model.values.tick import Tick
from record.log.blocks.message_form import Columns
from record.log.blocks.tick_forms import FormBook
from record.log.blocks.tick_inputs import inputs_of
from record.log.blocks.tick_outputs import same_outputs
from record.log.reader import TopicMessage, sound
from record.log.tick_message import LAYOUT, TickInputs, decode_inputs, says_the_same
from robot.control.ahead import Ahead
from robot.control.controller import Controller
from robot.control.state import ControllerState
from robot.replay.step_through import gap_words, step_recorded

BLOCK_TICKS = (
    128  # enough that numpy's overhead does not count; what they hold stays near the processor
)


@dataclass(frozen=True, slots=True, eq=False)
class SteppedBlock:
    """Some ticks of a log, and today's.

    Attributes:
        messages: As recorded.
        recorded: The inputs in them.
        ticks: Today's.
        groups: Messages of one form, and which they are.
        state: Of the controller after the last of them.
    """

    messages: list[TopicMessage]
    recorded: list[TickInputs]
    ticks: list[Tick]
    groups: list[tuple[list[int], Columns]]
    state: ControllerState

    def same(self, *, estimate: bool = True) -> list[bool]:
        """Tell which ticks are as recorded in every bit, with their estimates unless these are left out."""
        count = len(self.ticks)
        same = [False] * count
        for places, columns in self.groups:
            if places[-1] >= count:  # a gap ended the replay in the middle of the block
                continue
            ticks = [self.ticks[place] for place in places]
            alike = same_outputs(columns, ticks, estimate=estimate)
            for place, one in zip(places, alike.tolist(), strict=True):
                same[place] = one
        for place in [place for place, alike in enumerate(same) if not alike]:
            message, end = self.messages[place], self.recorded[place].end
            same[place] = says_the_same(
                self.ticks[place], message.data, end, message.layout, estimate=estimate
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
    """Step a controller through recorded inputs.

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
    reader = _Reader(messages, controller)
    index = first
    while block := reader.block():
        recorded: list[TickInputs] = []
        ticks: list[Tick] = []
        ahead = _ahead(controller, state, block)
        for place, message in enumerate(block.messages):
            inputs = block.inputs.get(place)
            if inputs is None:
                with sound(path, message):
                    inputs = decode_inputs(message.data, message.layout)
            if inputs.index != index:
                notes.append(gap_words(index, inputs.index))
                break
            state, tick = step_recorded(
                path,
                message,
                inputs,
                controller,
                state,
                ahead[place] if place < len(ahead) else None,
            )
            recorded.append(inputs)
            ticks.append(tick)
            index += 1
        if ticks:
            yield SteppedBlock(block.messages, recorded, ticks, block.groups, state)
        if len(ticks) < len(block.messages):
            return


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """Messages, the inputs of those of a usual form by their place, and the forms."""

    messages: list[TopicMessage]
    inputs: dict[int, TickInputs]
    groups: list[tuple[list[int], Columns]]


def _ahead(controller: Controller, state: ControllerState, block: _Block) -> list[Ahead]:
    """What can be computed of a block's ticks beforehand, up to the first unusual one."""
    usual = list(takewhile(block.inputs.__contains__, range(len(block.messages))))
    if not usual:
        return []
    inputs = [block.inputs[place].inputs for place in usual]
    return controller.ahead(state, inputs, [block.inputs[place].t_ns for place in usual])


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
        inputs: dict[int, TickInputs] = {}
        groups: list[tuple[list[int], Columns]] = []
        if all(message.layout == LAYOUT for message in messages):
            data = [message.data for message in messages]
            for places, columns in self._book.groups(data, self._machine):
                of_columns, own = inputs_of(columns), places.tolist()
                if of_columns is not None:
                    inputs.update(zip(own, of_columns, strict=True))
                groups.append((own, columns))
        return _Block(messages, inputs, groups)
