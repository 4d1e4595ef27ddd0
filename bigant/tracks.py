"""Odometry in a notebook: what ``bigant odom LOG --compare`` prints, as arrays."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bigant.logs import Log, path_of
from model.values.arrays import FloatArray
from robot.config.robot_file import RobotConfig
from robot.odometry.compare import OdometryComparison, compare_methods, stride_of
from robot.odometry.metrics import Motion, TrackErrors
from robot.odometry.table import displacement_and_sd, table
from robot.odometry.track import TrackedLog, track_log
from robot.requests.recorded import OdomRequest


@dataclass(frozen=True, eq=False, repr=False)
class Odometry:
    """The walking part of a log, T ticks of N legs, by the estimator and by simpler methods.

    Attributes:
        tracked: The log, the robot that was used, and every estimate.
        comparison: The estimator beside the simpler methods and the ground truth.
        path: The log.
    """

    tracked: TrackedLog
    comparison: OdometryComparison
    path: Path

    @property
    def t_s(self) -> FloatArray:
        """Time since the log's first tick, (T,) [s]."""
        return self.comparison.track.t_s

    @property
    def pose(self) -> FloatArray:
        """x, y [m], yaw [rad], in the estimator's own frame, (T, 3)."""
        return self.comparison.track.pose

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the displacement since the first of these ticks, (T, 3, 3)."""
        return self.comparison.track.displacement_covariance

    @property
    def velocity_B(self) -> FloatArray:  # noqa: N802 - frame suffix
        """Body velocity: vx, vy [m/s], yaw rate [rad/s], (T, 3)."""
        return self.comparison.track.velocity_B

    @property
    def force_B(self) -> FloatArray:  # noqa: N802
        """Ground's force on each foot, body axes, (T, N, 3) [N]."""
        return self.comparison.track.force_B

    @property
    def health(self) -> tuple[str, ...]:
        """``ok``, ``degraded`` or ``lost`` at each tick."""
        return tuple(one.value for one in self.comparison.track.estimates.healths)

    @property
    def truth(self) -> Motion | None:
        """Ground truth from the same pose on; None where the log has none for all of these ticks."""
        return self.comparison.truth

    @property
    def displacement(self) -> FloatArray:
        """x, y [m], yaw [rad] from the first of these ticks to the last, (3,)."""
        return displacement_and_sd(self.comparison)[0]

    @property
    def displacement_sd(self) -> FloatArray:
        """Standard deviations of ``displacement``, (3,)."""
        return displacement_and_sd(self.comparison)[1]

    @property
    def errors(self) -> Mapping[str, TrackErrors]:
        """Errors of each method against the ground truth, by its name; empty without ground truth."""
        return {one.name: one for one in self.comparison.errors}

    def save(self, out: str | Path) -> None:
        """Write .tum, .mcap, .png or .html, as ``bigant odom --out`` does.

        Raises:
            ConfigError: It is another kind of file.
            RecordError: It cannot be written.
        """
        from robot.odometry.files import write
        from robot.odometry.request import check

        check(OdomRequest(logs=(self.path,), compare=True, out=Path(out)))
        write(self.comparison, self.tracked.log, self.path, Path(out))

    def __repr__(self) -> str:
        """Return what the command prints."""
        return "\n".join(table(self.comparison))


def odometry(
    log: Log | str | Path,
    robot: RobotConfig | None = None,
    *,
    law: str | None = None,
    forces: bool = True,
    sway: bool = True,
) -> Odometry:
    """Run the estimator over a log, and compare it with simpler methods and the ground truth, if available.

    Args:
        log: Log with walking in it, or its file.
        robot: Robot to use; that of the log's own robot file if None.
        law: Friction law of the process, ``coulomb`` or ``viscous``; the robot file's if None.
        forces: Whether measured foot forces are used.
        sway: Whether the motion of the body as it tilts is accounted for.

    Raises:
        RecordError: The log cannot be read, or nobody walks in it.
        ConfigError: The robot file in it cannot be used, or the robot has other legs.
    """
    path = path_of(log)
    request = OdomRequest(logs=(path,), law=law, no_forces=not forces, no_sway=not sway)
    tracked = track_log(path, request, robot=robot)
    return Odometry(tracked, compare_methods(tracked, stride_m=stride_of(tracked.log)), path)
