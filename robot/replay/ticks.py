"""A log's inputs through today's controller, and its outputs against the recorded ones.

This is the step that the loop calls, and nothing else: a log is replayed by calling it in a row. Of
imported data, which no controller made, the estimator is what there is to replay: the same stage.
"""

import time
from collections.abc import Iterable, Iterator
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from model.errors import ConfigError, RecordError
from model.values.tick import Tick
from record.log.header import IMPORTED
from record.log.reader import (
    LogContents,
    TopicMessage,
    nothing_left,
    read_tick_messages,
    sound,
)
from record.log.tick_message import decode_inputs, decode_tick, says_the_same
from robot.config.robot_file import RobotConfig
from robot.console.processes import worth_processes
from robot.control.controller import Controller
from robot.control.tick_estimator import TickEstimator
from robot.replay.beside import estimator_beside
from robot.replay.blocks import step_in_blocks
from robot.replay.compare import ComparedRun, Comparison
from robot.replay.estimated import ComparedBlock
from robot.replay.fields import FIELDS
from robot.replay.step_through import in_order
from robot.replay.stretches import replay_stretches
from robot.run.rebuilt import config_of, rebuild_controller

NOT_BY_A_CONTROLLER = (
    "no controller made this log: the estimator is replayed, commands are not compared"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay(ComparedRun):
    """The result of a replay of inputs.

    Attributes:
        equal_bits: How many ticks are the same in every bit.
        complete: Whether the log holds every output that today's code has.
    """

    equal_bits: int
    complete: bool


def replay_log(
    path: Path,
    *,
    scale: float = 1.0,
    config: RobotConfig | None = None,
    contents: LogContents | None = None,
    gait: str | None = None,
    processes: bool = False,
) -> Replay:
    """Replay a log.

    Args:
        path: The log.
        scale: Factor on all tolerances; 0 asks for the same bits.
        config: Another robot file to try instead of the log's.
        contents: Filled on the way: robot file, metadata, damage, how far it is.
        gait: What may be run of a gait that a Python file gave: see ``with_gaits_of_log``.
        processes: Whether to replay a long log in processes, one a core. The result is the same; for
            programs whose main module can be imported again.

    Raises:
        RecordError: The log cannot be read, or holds no ticks; or it is imported and holds no estimate.
        ConfigError: Its robot file is none of today's.
    """
    contents = contents if contents is not None else LogContents()
    messages = read_tick_messages(path, contents)
    first_message = next(messages, None)
    if first_message is None:
        raise nothing_left(path, contents)
    messages = chain((first_message,), messages)
    notes: list[str] = []
    if imported(contents):
        _check_estimate(path, first_message, gait)
        robot = config if config is not None else config_of(contents)
        estimator = TickEstimator(robot)
        began = time.perf_counter()
        fields = [f for f in FIELDS if f.stage == "estimate"]
        notes.append(NOT_BY_A_CONTROLLER)
        steps = _estimate_through(path, messages, estimator, notes)
    else:
        if processes and config is None and worth_processes(path, first_message.layout):
            whole = _in_stretches(path, contents, gait, scale)
            if whole is None:  # no states in it, or something differs
                whole = _replay_in_two(path, messages, contents, gait, scale)
            if whole is not None:
                return whole
            contents.progress.begin_again()
            messages = read_tick_messages(path, contents)
        rebuilt = rebuild_controller(contents, config, gait, estimate=False)
        began = time.perf_counter()
        controller = rebuilt.controller
        robot = controller.config
        notes += rebuilt.run.notes
        fields = [f for f in FIELDS if rebuilt.run.forces_known or f.stage != "forces"]
        if first_message.layout == 1:
            notes.append("the log is older than the estimator: what that says is not compared")
            fields = [f for f in fields if f.stage != "estimate"]
        steps = _compared(path, messages, controller, notes)
    with sound(path, first_message):
        start_ns = now_ns = decode_inputs(first_message.data, first_message.layout).t_ns
    comparison = Comparison(fields, robot.parameters.legs.names, scale, start_ns)
    equal_bits = 0
    for t_ns, different in steps:
        now_ns = t_ns
        # the same bits need no second look, and taking a message apart costs more than making one
        if different is None:
            comparison.add_equal()
            equal_bits += 1
        else:
            comparison.add(*different)
    if contents.damage:
        notes.append(f"the file is {contents.damage}")
    if comparison.ticks == 0:
        raise RecordError(
            f"{path} does not begin with tick 0; a replay needs a log from its beginning"
        )
    return Replay(
        path=path,
        ticks=comparison.ticks,
        equal_bits=equal_bits,
        duration_s=(now_ns - start_ns) * 1e-9,
        wall_s=time.perf_counter() - began,
        fields=comparison.results(),
        first=comparison.first,
        notes=tuple(notes),
        complete=len(fields) == len(FIELDS),
    )


class _DifferentError(Exception):
    """Something is not the same in every bit."""


def _replay_in_two(
    path: Path,
    messages: Iterable[TopicMessage],
    contents: LogContents,
    gait: str | None,
    scale: float,
) -> Replay | None:
    """Replay controller and estimator apart; None if anything in the log is not the same in every bit."""
    rebuilt = rebuild_controller(contents, None, gait, estimate=False)
    config, notes, began = rebuilt.controller.config, [*rebuilt.run.notes], time.perf_counter()
    if not (rebuilt.run.forces_known and config.estimator.enabled):
        return None
    ticks = start_ns = now_ns = 0
    try:
        with estimator_beside(path, config) as estimated:
            for block in step_in_blocks(path, messages, rebuilt.controller, notes):
                if not block.same().all():
                    raise _DifferentError
                begin_ns, now_ns = block.times_ns
                start_ns, ticks = start_ns if ticks else begin_ns, ticks + len(block)
                if estimated.done() and estimated.result() < ticks:
                    raise _DifferentError
            if estimated.result() < ticks or not ticks:
                raise _DifferentError
    except (_DifferentError, BrokenExecutor):  # or the other process is gone
        return None
    return Replay(
        path=path,
        ticks=ticks,
        equal_bits=ticks,
        duration_s=(now_ns - start_ns) * 1e-9,
        wall_s=time.perf_counter() - began,
        fields=Comparison(FIELDS, config.parameters.legs.names, scale, start_ns).results(),
        first=None,
        notes=(*notes, *([f"the file is {contents.damage}"] if contents.damage else [])),
        complete=True,
    )


def _in_stretches(
    path: Path, contents: LogContents, gait: str | None, scale: float
) -> Replay | None:
    """Replay a log on all cores; None if it cannot be divided, or anything in it is not the same."""
    began = time.perf_counter()
    whole = replay_stretches(path, contents, gait)
    if whole is None:
        return None
    config, duration_s = whole.run.config, (whole.last_ns - whole.first_ns) * 1e-9
    return Replay(
        path=path,
        ticks=whole.ticks,
        equal_bits=whole.ticks,
        duration_s=duration_s,
        wall_s=time.perf_counter() - began,
        fields=Comparison(FIELDS, config.parameters.legs.names, scale, whole.first_ns).results(),
        first=None,
        notes=whole.run.notes,
        complete=True,
    )


# Time of a tick; as recorded, and today's, if they are not the same in every bit.
Compared = tuple[int, tuple[Tick, Tick] | None]


def _compared(
    path: Path, messages: Iterable[TopicMessage], controller: Controller, notes: list[str]
) -> Iterator[Compared]:
    """Step a controller, and its estimator, through recorded inputs.

    Raises:
        RecordError: A tick is damaged.
    """
    config = controller.config
    estimator = TickEstimator(config) if config.estimator.enabled else None
    for block in step_in_blocks(path, messages, controller, notes):
        compared = ComparedBlock(block, estimator)
        for place, same in enumerate(compared.same().tolist()):
            message, different = block.messages[place], None
            if not same:
                recorded = block.recorded(place)
                with sound(path, message):
                    then = decode_tick(message.data, message.layout, recorded)
                different = then, compared.tick(place)
            yield block.time_ns(place), different


def _estimate_through(
    path: Path, messages: Iterable[TopicMessage], estimator: TickEstimator, notes: list[str]
) -> Iterator[Compared]:
    """Step an estimator through recorded ticks: as ``_compared``, and all but the estimate is the log's.

    Raises:
        RecordError: A tick is damaged.
        ConfigError: The robot has other legs than the log.
    """
    for message, recorded in in_order(path, messages, notes):
        with sound(path, message):
            tick = decode_tick(message.data, message.layout, recorded)
        now = replace(tick, estimate=estimator.step(tick.sensed))
        same = says_the_same(now, message.data, recorded.end, message.layout)
        yield tick.t_ns, None if same else (tick, now)


def _check_estimate(path: Path, first_message: TopicMessage, gait: str | None) -> None:
    """Refuse imported ticks without an estimate to compare with.

    Raises:
        RecordError: They hold none.
        ConfigError: A gait is named, and there is none to run.
    """
    with sound(path, first_message):
        first = decode_tick(first_message.data, first_message.layout)
    if first.estimate is None:
        raise RecordError(
            f"{path} holds no estimate to compare with, and no controller made it; import its table again "
            "with its robot file, or see what the estimator makes of it: bigant odom LOG"
        )
    if gait is not None:
        raise ConfigError("--gait", "no controller made this log, so no gait is run; leave it out")


def imported(contents: LogContents) -> bool:
    """Whether a log is imported data, which no controller made."""
    return contents.metadata.get("hardware") == IMPORTED
