"""What is measured in a walk, row by row, and the trial that it makes."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from model.values.arrays import FloatArray, readonly
from model.values.legs import FootForces, JointState
from record.trial.header import LEGGED, TrialHeader, TrialNoise
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig
from sim_hw.twin.motion_capture import Poses

ROBOT_FILE = "robot.toml"


@dataclass(slots=True)
class TwinRows:
    """Rows of a walk, appended as they come."""

    t_ns: list[int] = field(default_factory=list)
    command_rad: list[FloatArray] = field(default_factory=list)
    joints: list[JointState] = field(default_factory=list)
    forces: list[FootForces] = field(default_factory=list)


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
    turns = Rotation.from_quat(poses.quaternion_xyzw)
    yaw, pitch, roll = turns.as_euler("ZYX").T
    arms = poses.foot_position_W - poses.position_W[:, None, :]
    feet = np.einsum("tji,tnj->tni", turns.as_matrix(), arms)

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
        body_position_m=readonly(poses.position_W),
        body_angles_rad=readonly(np.stack([roll, pitch, np.unwrap(yaw)], axis=1)),
    )
