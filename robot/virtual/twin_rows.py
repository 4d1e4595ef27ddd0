"""What is measured in a walk, row by row, and the trial that it makes."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.values.arrays import FloatArray, readonly
from model.values.legs import FootForces, JointState
from model.values.readings import BodyTruth
from model.values.tick import Mode, Tick
from record.trial.header import LEGGED, TrialHeader, TrialNoise
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig
from sim_hw.twin.motion_capture import Poses

ROBOT_FILE = "robot.toml"
# Time [ns], body in the world (3,) [m], body to world x y z w (4,), feet in the world (N, 3) [m].
Place: TypeAlias = tuple[int, FloatArray, FloatArray, FloatArray]


class TwinRows:
    """A sink that keeps what a trial needs of the ticks of walking.

    Args:
        seconds: Length of the trial, from the first tick of walking on.
    """

    error: RecordError | None = None

    def __init__(self, seconds: float) -> None:
        self.first = 0  # ticks before it
        self.t_ns: list[int] = []
        self.command_rad: list[FloatArray] = []
        self.joints: list[JointState] = []
        self.forces: list[FootForces] = []
        self.truths: list[BodyTruth | None] = []
        self._length_ns = round(seconds * 1e9)

    def write(self, tick: Tick) -> None:
        """Keep a tick if it belongs to the trial."""
        if tick.mode is not Mode.WALK:
            self.first += not self.t_ns
            return
        if self.t_ns and tick.t_ns - self.t_ns[0] >= self._length_ns:
            return
        self.t_ns.append(tick.t_ns)
        self.command_rad.append(tick.sent.angle_rad)
        self.joints.append(tick.joints)
        self.forces.append(tick.forces)
        self.truths.append(tick.inputs.truth)


def poses_of(places: Sequence[Place]) -> Poses:
    """Return places one behind the other as arrays."""
    return Poses(*(np.array(column) for column in zip(*places, strict=True)))


def trial_header(
    config: RobotConfig, gait: str, frequency_hz: float, noise: TrialNoise
) -> TrialHeader:
    """Return the header of a trial; nothing in it depends on what is wrong with the robot."""
    return TrialHeader(
        kind=LEGGED,
        joints=config.parameters.legs.names,
        gait=gait,
        frequency_hz=frequency_hz,
        sample_rate_hz=float(config.loop.rate_hz),
        notes="",
        noise=noise,
        robot_file=ROBOT_FILE,
        robot_text=config.text,
    )


def trial_of(rows: TwinRows, poses: Poses, header: TrialHeader) -> Trial:
    """Make a trial of rows and of the poses that the cameras gave for the same times."""
    t_ns = np.array(rows.t_ns)
    position, angles, feet = body_of(poses)

    def stack(name: str) -> FloatArray:
        return readonly(np.array([getattr(joints, name) for joints in rows.joints]))

    nothing = readonly(np.full((len(t_ns), len(header.joints)), np.nan))
    return Trial(
        header,
        time_s=readonly((t_ns - t_ns[0]) * 1e-9),
        command_rad=readonly(np.array(rows.command_rad)),
        shaft_rad=stack("angle_rad"),
        shaft_rad_s=stack("rate_rad_s"),
        current_a=stack("current_a"),
        voltage_v=stack("voltage_v"),
        temperature_c=stack("temperature_c"),
        pwm=nothing,
        torque_nm=nothing,
        foot_m=readonly(feet),
        force_n=readonly(np.array([forces.force_n for forces in rows.forces])),
        body_position_m=readonly(position),
        body_angles_rad=readonly(angles),
    )


def body_of(poses: Poses) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position (T, 3), roll, pitch and yaw (T, 3), and feet in the body (T, N, 3), as a trial has them."""
    turns = Rotation.from_quat(poses.quaternion_xyzw)
    yaw, pitch, roll = turns.as_euler("ZYX").T
    arms = poses.foot_position_W - poses.position_W[:, None, :]
    feet = np.einsum("tji,tnj->tni", turns.as_matrix(), arms)
    return poses.position_W, np.stack([roll, pitch, np.unwrap(yaw)], axis=1), feet
