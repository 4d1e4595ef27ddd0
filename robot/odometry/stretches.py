"""The estimator over a long log in stretches, on all cores at once: from a state in the log to the next.

A stretch counts only if the estimator ends it with what the log says that it remembered there, to the bit.
Then the stretches together are one pass over the log. If any ends otherwise (the log is of another version,
or cut), nothing is concluded from it, and the log is read from its first tick on.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

from model.errors import BigantError
from record.growing_array import GrowingTable
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_tick_messages
from record.log.recording import GrowingRecording, Recording
from record.log.salvage import DAMAGE
from record.log.stretches import Stretch, find_stretches
from robot.config.robot_file import RobotConfig
from robot.console.processes import worth_processes
from robot.console.stretch_pool import DifferentError, in_stretches
from robot.control.state_bytes import bytes_of_estimator, estimator_of_bytes
from robot.odometry.estimates import EstimateColumns
from robot.odometry.request import believed_robot
from robot.odometry.track import Track, TrackedLog, Tracker
from robot.requests.recorded import OdomRequest

UNKNOWN_NS = -1
BESIDE = ("unix_ns", "step_us", "rejections", "anchored")  # of a track, beside the estimates


@dataclass(frozen=True, slots=True)
class TrackTask:
    """What a process needs for a stretch: the log with its robot file and metadata, and the stretch."""

    path: Path
    config_text: str
    metadata: tuple[tuple[str, str], ...]
    stretch: Stretch


@dataclass(frozen=True, slots=True, eq=False)
class TrackedStretch:
    """The recording of a stretch, and the estimates in it."""

    log: Recording
    track: Track


class GrowingTrack:
    """Stretches of a log, put together as they come.

    Attributes:
        log: Their recording.
    """

    def __init__(self) -> None:
        self.log = GrowingRecording()
        self._estimates = EstimateColumns()
        self._fields = GrowingTable()

    def add(self, part: TrackedStretch) -> None:
        """Add the next stretch."""
        self.log.add(part.log)
        self._estimates.extend(part.track.estimates)
        self._fields.extend({name: getattr(part.track, name) for name in BESIDE})

    def track(self) -> Track:
        """Return the track of the whole so far, of at least one stretch."""
        columns = self._fields.arrays()
        unix_ns = columns["unix_ns"]
        return Track(
            t_s=(unix_ns - unix_ns[0]) * 1e-9,
            estimates=self._estimates.estimates(),
            states=(),
            **columns,
        )


def track_stretches(path: Path, request: OdomRequest, contents: LogContents) -> TrackedLog | None:
    """Run the estimator over a log on all cores: as ``track_log``.

    Args:
        path: The log.
        request: What to use in place of its robot file.
        contents: Filled as the log is read.

    Returns:
        None if the log cannot be divided, is not worth it, or other settings than its own are asked for.

    Raises:
        RecordError: The log cannot be read.
        ConfigError: Its robot file is none.
    """
    if not _with_its_own_settings(request):
        return None
    first = next(read_tick_messages(path, contents), None)
    known = contents.config_text and contents.start_unix_ns(UNKNOWN_NS) != UNKNOWN_NS
    if first is None or not known or not worth_processes(path, first.layout):
        return None
    metadata = tuple(contents.metadata.items())
    tasks = [
        TrackTask(path, contents.config_text, metadata, stretch) for stretch in find_stretches(path)
    ]
    if len(tasks) < 2:
        return None
    whole = GrowingTrack()
    if not in_stretches(path, tasks, track_stretch, contents.progress, whole.add):
        return None
    config = believed_robot(request, contents.config_text)
    log = replace(whole.log.recording(damage=""), metadata=contents.metadata)
    return TrackedLog(log, config, whole.track())


def _with_its_own_settings(request: OdomRequest) -> bool:
    others = (request.robot, request.law)
    switched = (request.no_sway, request.no_forces, request.no_imu, request.smooth)
    return others == (None, None) and not any(switched)


def track_stretch(task: TrackTask) -> TrackedStretch | None:
    """Run the estimator over a stretch; None if it does not end as the log says, or cannot be read."""
    try:
        return _track_stretch(task)
    except (DifferentError, BigantError, *DAMAGE):
        return None


def _track_stretch(task: TrackTask) -> TrackedStretch:
    stretch, tracker = task.stretch, Tracker(_robot(task.config_text), blocks=True)
    if stretch.before is not None:
        memory = estimator_of_bytes(stretch.before)
        if memory is None:
            raise DifferentError
        tracker.begin_at(memory)
    metadata: Mapping[str, str] = MappingProxyType(dict(task.metadata))
    contents = LogContents(task.config_text, metadata)
    log = read_log(task.path, contents, tracker.take_block, stretch=stretch)
    if contents.damages or (
        stretch.end is not None and len(log.t_s) != stretch.end - stretch.begin
    ):
        raise DifferentError
    if stretch.after is not None:
        ended = estimator_of_bytes(stretch.after)
        if ended is None or bytes_of_estimator(ended) != bytes_of_estimator(tracker.memory):
            raise DifferentError
    # who asked has the metadata, and a view of a mapping does not go from process to process
    return TrackedStretch(replace(log, metadata={}), tracker.track())


@cache
def _robot(config_text: str) -> RobotConfig:
    return believed_robot(OdomRequest(), config_text)
