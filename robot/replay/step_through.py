"""Recorded inputs through a controller, tick after tick: the walk through a log that replays take."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from model.values.faults import SERVO_EVENTS, Fault, FaultKind, ServoEvent
from model.values.tick import Inputs, Tick
from record.log.reader import TopicMessage, damaged, sound
from record.log.tick_message import TickInputs, decode_inputs
from robot.control.controller import Controller
from robot.control.state import ControllerState


def step_through(
    path: Path, messages: Iterable[TopicMessage], controller: Controller, notes: list[str]
) -> Iterator[tuple[TopicMessage, TickInputs, Tick]]:
    """Step a controller through recorded inputs, from the first tick on.

    Args:
        path: The log.
        messages: Its ticks as messages, from the first one on.
        controller: The controller.
        notes: Gets a line where the log has a gap; the replay ends there.

    Yields:
        The message, the inputs in it, and today's tick.

    Raises:
        RecordError: A tick is damaged.
    """
    state = controller.initial()
    for message, recorded in in_order(path, messages, notes):
        state, tick = step_recorded(path, message, recorded, controller, state)
        yield message, recorded, tick


def step_recorded(
    path: Path,
    message: TopicMessage,
    recorded: TickInputs,
    controller: Controller,
    state: ControllerState,
) -> tuple[ControllerState, Tick]:
    """Step a controller by the inputs in a message.

    Raises:
        RecordError: The tick is damaged.
    """
    servos, names = recorded.inputs.servos, controller.config.servo_bus.names
    if servos is not None and len(servos.valid) != len(names):
        error = ValueError(f"it has {len(servos.valid)} legs and not {len(names)}")
        raise damaged(path, message, error) from error
    events = servo_events(recorded.inputs.faults, names)
    inputs: Inputs = recorded.inputs
    if events:
        inputs = replace(inputs, servo_events=events)
    return controller.step(state, inputs, recorded.t_ns)


def in_order(
    path: Path, messages: Iterable[TopicMessage], notes: list[str]
) -> Iterator[tuple[TopicMessage, TickInputs]]:
    """Yield messages with their inputs from tick 0 to the first gap, which gets a line in ``notes``.

    Raises:
        RecordError: A tick is damaged.
    """
    for index, message in enumerate(messages):
        with sound(path, message):
            recorded = decode_inputs(message.data, message.layout)
        if recorded.index != index:
            notes.append(gap_words(index, recorded.index))
            return
        yield message, recorded


def servo_events(faults: Sequence[Fault], names: Sequence[str]) -> tuple[ServoEvent, ...]:
    """Return the servo events of a tick from a log, which keeps only the faults that go with them.

    Args:
        faults: Faults among the tick's inputs.
        names: Leg names.
    """
    if not faults:
        return ()
    events = [
        ServoEvent(names.index(fault.source), fault.kind)
        for fault in faults
        if fault.kind in SERVO_EVENTS and fault.source in names
    ]
    # the result of a recovery was known before the servos were read
    return tuple(sorted(events, key=lambda event: event.kind is FaultKind.SERVO_DOWN))


def gap_words(expected: int, index: int) -> str:
    """Say what is wrong where a tick has another number than expected."""
    if index < expected:
        return "another run begins here (the log is merged): only the first is replayed"
    return (
        f"ticks {expected} to {index - 1} are missing from the log: only what is before them is "
        "replayed"
    )
