"""A long log replayed in stretches, on all cores at once: each from a state that the log holds to the next.

A stretch counts only if every tick of it is the same in every bit as the recorded one, and so is the state
it ends with. Then the stretches together are the replay of the whole. If anything differs, nothing is
concluded from it: the log is then replayed tick by tick.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

from model.errors import BigantError
from model.values.estimate import Estimate
from record.log.reader import LogContents
from record.log.salvage import DAMAGE
from record.log.stretches import Stretch, find_stretches, read_stretch
from robot.console.stretch_pool import DifferentError, in_stretches
from robot.control.controller import Controller
from robot.control.state_bytes import bytes_of_state, state_of_bytes
from robot.control.tick_estimator import TickEstimator
from robot.replay.blocks import step_in_blocks
from robot.replay.estimated import ComparedBlock
from robot.run.rebuilt import RecordedRun, rebuild_controller, recorded_run

Texts = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class StretchTask:
    """What a process needs to replay a stretch.

    Attributes:
        path: The log.
        config_text: Its robot file.
        metadata: Its metadata.
        gait: What may be run of a gait that a Python file gave.
        stretch: The stretch.
    """

    path: Path
    config_text: str
    metadata: Texts
    gait: str | None
    stretch: Stretch


@dataclass(frozen=True, slots=True)
class StretchDone:
    """A stretch that is the same in every bit: its ticks, and times of the first and the last [ns]."""

    ticks: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class ReplayedStretches:
    """A log that is the same in every bit.

    Attributes:
        run: What it says of its controller.
        ticks: How many.
        first_ns: Time of the first.
        last_ns: Time of the last.
    """

    run: RecordedRun
    ticks: int
    first_ns: int
    last_ns: int


def replay_stretches(
    path: Path, contents: LogContents, gait: str | None
) -> ReplayedStretches | None:
    """Replay a log on all cores.

    Args:
        path: The log.
        contents: Robot file and metadata, read already; how far the replay has come is told in it.
        gait: As for ``rebuild_controller``.

    Returns:
        None if the log cannot be divided, or anything in it is not the same in every bit.

    Raises:
        RecordError: As ``recorded_run``, as does the next.
        ConfigError: The robot file is none of today's.
    """
    stretches = find_stretches(path)
    if len(stretches) < 2:
        return None
    metadata = tuple(contents.metadata.items())
    tasks = [StretchTask(path, contents.config_text, metadata, gait, one) for one in stretches]
    run = recorded_run(contents, None, gait)  # the controller itself is built where it steps
    done: list[StretchDone] = []
    if not in_stretches(path, tasks, replay_stretch, contents.progress, done.append):
        return None
    ticks = sum(one.ticks for one in done)
    return ReplayedStretches(run, ticks, done[0].first_ns, done[-1].last_ns)


def replay_stretch(task: StretchTask) -> StretchDone | None:
    """Replay a stretch; None if anything in it is not the same in every bit, or cannot be read."""
    try:
        return _replay_stretch(task)
    except (DifferentError, BigantError, *DAMAGE):
        return None


def _replay_stretch(task: StretchTask) -> StretchDone:
    path, stretch = task.path, task.stretch
    controller = _controller(task.config_text, task.metadata, task.gait)
    estimator = TickEstimator(controller.config, blocks=True)
    state = controller.initial()
    if stretch.before is not None:
        state = state_of_bytes(stretch.before, controller.book.gaits)
        if state.estimates.estimator is None:
            raise DifferentError
        estimator.memory = state.estimates.estimator
    first_ns, now_ns, index = -1, -1, stretch.begin
    contents = LogContents(task.config_text, MappingProxyType(dict(task.metadata)))
    messages, gaps = read_stretch(path, contents, stretch), list[str]()
    newest: Estimate | None = None
    for block in step_in_blocks(path, messages, controller, gaps, state, index):
        if gaps:
            raise DifferentError
        compared = ComparedBlock(block, estimator)
        if not compared.same().all():
            raise DifferentError
        begin_ns, now_ns = block.times_ns
        first_ns = first_ns if index > stretch.begin else begin_ns
        newest, state = compared.newest, block.state
        index += len(block)
    if gaps:
        raise DifferentError
    whole = index == stretch.end if stretch.end is not None else index > stretch.begin
    estimates = replace(state.estimates, estimate=newest, estimator=estimator.memory)
    state = replace(state, estimates=estimates)
    ends_alike = stretch.after is None or bytes_of_state(state) == stretch.after
    if contents.damages or not (whole and ends_alike):
        raise DifferentError
    return StretchDone(index - stretch.begin, first_ns, now_ns)


@cache
def _controller(config_text: str, metadata: Texts, gait: str | None) -> Controller:
    """The controller of a log without its estimator, built once in a process."""
    known: Mapping[str, str] = MappingProxyType(dict(metadata))
    rebuilt = rebuild_controller(LogContents(config_text, known), None, gait, estimate=False)
    if not (rebuilt.run.forces_known and rebuilt.controller.config.estimator.enabled):
        raise DifferentError
    return rebuilt.controller
