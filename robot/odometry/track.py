"""The estimator over the ticks of a log: the loop's own stage, with what the loop knew at each tick."""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from drivers.ati.foot_forces import no_forces
from model.errors import ModelError
from model.estimator.block.places import ANCHORED, FAR_POSES, REJECTED
from model.estimator.block.run import EstimatedBlock
from model.estimator.sources import ABSOLUTE
from model.values.arrays import BoolArray, FloatArray, IntArray, part_of, readonly
from model.values.estimate import Estimate, EstimatorState, paired_covariance
from model.values.tick import SensedTick
from model.values.tick_rows import ForceRows, SensedRows
from record.log.blocks.read import read_log
from record.log.reader import LogContents, StampedTick
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig
from robot.console.processes import is_long
from robot.control.estimator_stage import StageMemory
from robot.control.tick_estimator import SingleTick, TickEstimator
from robot.odometry.estimates import EstimateColumns, EstimateSeries
from robot.odometry.request import believed_robot
from robot.requests.recorded import OdomRequest

# Where a displacement begins, its pose is known to this [m, rad], as in the estimator's first tick.
START_SD = 1e-4
BLOCK_TICKS = 8192  # at a time, where each takes kilobytes


@dataclass(frozen=True, eq=False)
class Track:
    """What the estimator reported over T ticks of N legs, in its own frame.

    Attributes:
        t_s: Time since the log's first tick, (T,).
        unix_ns: UNIX time of each, (T,).
        estimates: All of them, one a tick.
        states: What it remembered after each, for smoothing; empty unless asked for.
        step_us: Time of each step [us], with whatever else the machine was doing, (T,).
        rejections: Measurements rejected in each, by kind and leg as in ``EstimatorState.rejected``,
            (T, 5, N).
        anchored: Whether an absolute position is in the estimate, (T,).
    """

    t_s: FloatArray
    unix_ns: IntArray
    estimates: EstimateSeries
    states: tuple[EstimatorState, ...]
    step_us: FloatArray
    rejections: BoolArray
    anchored: BoolArray

    def part(self, span: slice) -> "Track":
        """Return some of the ticks."""
        return part_of(self, span)

    def column(self, name: str) -> FloatArray:
        """Return a field of each estimate, (T, ...); its names are those of ``Estimate``."""
        return self.estimates.column(name)

    @cached_property
    def pose(self) -> FloatArray:
        """x, y [m], yaw [rad], (T, 3)."""
        return np.column_stack([self.column("position_m"), self.column("yaw_rad")])

    @cached_property
    def velocity_B(self) -> FloatArray:  # noqa: N802 - frame suffix
        """Body velocity: vx, vy [m/s], yaw rate [rad/s], (T, 3)."""
        return self.column("velocity_B")

    @cached_property
    def force_B(self) -> FloatArray:  # noqa: N802
        """Predicted foot forces, (T, N, 3) [N]."""
        return self.column("force_B")

    @cached_property
    def displacement_covariance(self) -> FloatArray:
        """Covariance of the displacement since the first tick, (T, 3, 3): the growth of the pose's.

        Once an absolute pose is used, the pose does not hang on the first one any more: then it is the sum
        of both covariances. Of robots of other tolerances only how far they part from then on counts.

        What is learned of a leg says something of the first pose, too, and the difference falls. In a walk
        where it falls below nothing, the displacement stays as uncertain as it has once been.
        """
        free = np.logical_or.accumulate(self.anchored)
        free[0] = False  # of no displacement nothing is unknown
        spans = (slice(at, at + BLOCK_TICKS) for at in range(0, len(free), BLOCK_TICKS))
        grown = np.concatenate([self._displacement_covariance(span, free[span]) for span in spans])
        hanging = grown[~free]
        if (np.linalg.eigvalsh(hanging)[:, 0] <= 0.0).any():
            grown[~free] = hanging[_largest_until(np.trace(hanging[:, :2, :2], axis1=1, axis2=2))]
        return grown

    def _displacement_covariance(self, span: slice, free: BoolArray) -> FloatArray:
        """The same over some ticks; ``free`` says in which the pose does not hang on the first one."""
        every, covariances = self.column("companion_pose"), self.column("pose_covariance")
        apart, first = every[span], covariances[0] - paired_covariance(every[:1])[0]
        covariance = covariances[span] - paired_covariance(apart)
        moved = self.pose[span] - self.pose[0]
        # a turn at the first tick moves all later places
        carried = np.tile(np.eye(3), (len(moved), 1, 1))
        carried[:, 0, 2], carried[:, 1, 2] = -moved[:, 1], moved[:, 0]
        known = carried @ first @ carried.transpose(0, 2, 1)
        sign = np.where(free, 1.0, -1.0)[:, None, None]
        since = apart - np.where(
            free[:, None, None], 0.0, np.einsum("tij,mj->tmi", carried, every[0])
        )
        grown: FloatArray = (
            covariance + sign * known + paired_covariance(since) + START_SD**2 * np.eye(3)
        )
        return grown

    @cached_property
    def nis_over_dof(self) -> FloatArray:
        """Normalised innovations squared over their numbers, of the ticks with a measurement."""
        nis, dof = self.column("nis"), self.column("nis_dof")
        return nis[dof > 0] / dof[dof > 0]

    @property
    def rejected(self) -> int:
        """Measurements rejected since the first tick."""
        first, last = self.column("rejects")[[0, -1]]
        return int(last - first)


def _largest_until(values: FloatArray) -> IntArray:
    """Return the place of the largest value up to each, (T,)."""
    largest = np.maximum.accumulate(values)
    new = np.flatnonzero(np.diff(largest, prepend=-np.inf))
    places: IntArray = new[np.searchsorted(new, np.arange(len(values)), side="right") - 1]
    return places


class Tracker:
    """The estimator stage over the ticks of somebody else's loop, with the robot file to use.

    Foot forces and the IMU can be kept from it, and what a smoother needs can be kept.
    """

    def __init__(
        self,
        config: RobotConfig,
        *,
        no_forces: bool = False,
        no_imu: bool = False,
        keep_states: bool = False,
        blocks: bool = False,
    ) -> None:
        self.config = config
        self._estimator = TickEstimator(config, blocks=blocks and not keep_states)
        self._no_forces, self._no_imu = no_forces, no_imu
        self._keep_states = keep_states
        self._unix_ns: list[int] = []
        self._estimates = EstimateColumns()
        self._states: list[EstimatorState] = []
        self._step_us: list[float] = []
        self._rejections: list[BoolArray] = []
        self._anchored: list[bool] = []

    @property
    def memory(self) -> StageMemory:
        """What the estimator remembers."""
        return self._estimator.memory

    def begin_at(self, memory: StageMemory) -> None:
        """Begin with what an estimator remembered in the middle of a log."""
        self._estimator.memory = memory

    def step(self, tick: SensedTick) -> Estimate:
        """Advance by a tick; nothing is kept of it.

        Raises:
            ConfigError: The robot has other legs than the tick.
        """
        return self._estimator.step(self._shown(tick))

    def take_block(self, unix_ns: Sequence[int], ticks: SensedRows) -> None:
        """Advance by ticks that were at UNIX times, and keep the estimates: as ``take``."""
        self._unix_ns += unix_ns
        began = time.perf_counter_ns()
        for part in self._estimator.through(self._rows_shown(ticks)):
            count = 1
            if isinstance(part, SingleTick):
                self._keep(part)
            else:
                count = len(part)
                self._keep_block(part.block)
            ended = time.perf_counter_ns()
            self._step_us += [(ended - began) / (1e3 * count)] * count
            began = ended

    def take(self, unix_ns: int, tick: SensedTick) -> None:
        """Advance by a tick that was at a UNIX time, and keep the estimate."""
        before = self._estimator.memory
        began = time.perf_counter_ns()
        estimate = self.step(tick)
        self._step_us.append((time.perf_counter_ns() - began) / 1e3)
        self._unix_ns.append(unix_ns)
        self._keep(SingleTick(before, self._estimator.memory, estimate))

    def _shown(self, tick: SensedTick) -> SensedTick:
        """What of a tick the estimator may know."""
        if self._no_forces:
            tick = replace(tick, forces=no_forces(len(tick.forces.force_n)))
        if self._no_imu and tick.imu:
            tick = replace(tick, imu=())
        return tick

    def _rows_shown(self, ticks: SensedRows) -> SensedRows:
        """What of ticks the estimator may know."""
        if self._no_forces:
            nothing = no_forces(ticks.sizes[0])
            ticks = replace(ticks, forces=ForceRows.stacked([nothing] * len(ticks)))
        if self._no_imu:
            ticks = replace(ticks, imu=[()] * len(ticks))
        return ticks

    def _keep(self, tick: SingleTick) -> None:
        self._estimates.add(tick.estimate)
        memory = tick.after.estimator
        self._rejections.append(_rejected(tick.before.estimator.state, memory.state))
        self._anchored.append(memory.state.anchored)
        if self._keep_states:
            # a late pose changes the states of the moments before, too
            newest = [*(state for state, _ in memory.ticks[1:]), memory.state]
            self._states[len(self._states) + 1 - len(newest) :] = newest

    def _keep_block(self, block: EstimatedBlock) -> None:
        self._estimates.add_block(block)
        rejected, far = block.rows.wholes(REJECTED), block.rows.wholes(FAR_POSES)
        more: BoolArray = rejected[1:] > rejected[:-1]
        more[:, ABSOLUTE, 0] |= far[1:] > far[:-1]
        self._rejections += list(more)
        self._anchored += block.rows.all_flags(ANCHORED)[1:].tolist()

    def track(self) -> Track:
        """Return the estimates so far.

        Raises:
            ModelError: There was no tick.
        """
        if not self._unix_ns:
            raise ModelError("there is no tick to estimate from; record a longer walk")
        unix_ns = np.array(self._unix_ns)
        return Track(
            t_s=(unix_ns - unix_ns[0]) * 1e-9,
            unix_ns=unix_ns,
            estimates=self._estimates.estimates(),
            states=tuple(self._states),
            step_us=np.array(self._step_us),
            rejections=np.array(self._rejections),
            anchored=np.array(self._anchored),
        )


def _rejected(before: EstimatorState, after: EstimatorState) -> BoolArray:
    """Which measurements were rejected between two states, (5, N): each counts its rejections in a row."""
    if after.rejected is before.rejected and after.far_poses == before.far_poses:
        return _none(*before.rejected.shape)  # nothing was measured
    rejected: BoolArray = after.rejected > before.rejected
    rejected[ABSOLUTE, 0] |= after.far_poses > before.far_poses
    return rejected


@cache
def _none(kinds: int, legs: int) -> BoolArray:
    """No rejection at all."""
    return readonly(np.zeros((kinds, legs), dtype=bool))


def track(items: Iterable[StampedTick], config: RobotConfig) -> Track:
    """Run the estimator of a robot file over ticks.

    Raises:
        ModelError: There are none.
    """
    tracker = Tracker(config)
    for item in items:
        tracker.take(item.unix_ns, item.tick.sensed)
    return tracker.track()


@dataclass(frozen=True, slots=True, eq=False)
class TrackedLog:
    """A log, the robot that the estimator used, and its estimate in every tick."""

    log: Recording
    config: RobotConfig
    track: Track


def track_log(
    path: Path,
    request: OdomRequest | None = None,
    contents: LogContents | None = None,
    robot: RobotConfig | None = None,
) -> TrackedLog:
    """Run the estimator over a log: with its own robot file the result is that of the loop.

    The request says what to use in place of that file, and whether states are kept for smoothing;
    ``contents`` is filled as the log is read. A ``robot`` that is read already stands in for the file of
    the request.

    Raises:
        RecordError: The log cannot be read, or holds no tick.
        ConfigError: The robot file is none.
    """
    given = request if request is not None else OdomRequest()
    log_contents = contents if contents is not None else LogContents()
    trackers: list[Tracker] = []

    def take(unix_ns: Sequence[int], ticks: SensedRows) -> None:
        if not trackers:  # the robot file comes before the first tick
            config = believed_robot(given, log_contents.config_text, robot)
            trackers.append(
                Tracker(
                    config,
                    no_forces=given.no_forces,
                    no_imu=given.no_imu,
                    keep_states=given.smooth,
                    blocks=is_long(path),
                )
            )
        trackers[0].take_block(unix_ns, ticks)

    log = read_log(path, log_contents, take)
    (tracker,) = trackers
    return TrackedLog(log, tracker.config, tracker.track())
