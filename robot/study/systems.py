"""Named systems for the command line: which options each one takes, and BigANT from its robot file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gaits.catalog import make_gait
from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrictionLaw
from model.systems import disk, multipod, quadruped, slither, stairs
from model.systems.system import System, even_times
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import RobotParameters
from robot.config.gait_file import with_gait
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE

DEFAULT_CYCLES = {
    "bigant": 4.0, "disk": 4.0, "multipod": 4.0, "quadruped": 9.0, "stairs": 15.0, "slither": 4.0
}  # fmt: skip
MOST_CYCLES = 1000.0
BODY_MARGIN_M = 0.03  # of the drawn body around the shafts
SHAFT_SHARE = 0.7  # of the shafts' distance from the middle that the drawn body reaches
# Systems of any number of legs, with the usual one.
WITH_LEGS: dict[str, tuple[Callable[..., System], int]] = {
    "disk": (disk.disk, 6), "multipod": (multipod.multipod, 6), "slither": (slither.slither, 16)
}  # fmt: skip


def build_system(
    name: str,
    *,
    legs: int | None = None,
    gait: str | None = None,
    cycles: float | None = None,
    robot_file: Path | None = None,
    law: FrictionLaw = FrictionLaw.VISCOUS,
    tilt_coupling: bool = False,
) -> System:
    """Build a system by name, one of ``DEFAULT_CYCLES``; None takes the system's own default.

    Args:
        name: Of the system.
        legs: Number of legs or contacts.
        gait: BigANT's gait, of its robot file or of a Python file.
        cycles: Length of the motion in gait cycles.
        robot_file: BigANT's robot file.
        law: Friction law; stairs need it, because where the feet land depends on it.
        tilt_coupling: As in ``solve_frames``; for stairs likewise.

    Raises:
        ConfigError: An option the system does not take, or an impossible value.
        ModelError: A number of legs the system cannot have.
    """
    if name not in DEFAULT_CYCLES:
        raise ConfigError("system", f"{name!r} is none; choose from {', '.join(DEFAULT_CYCLES)}")
    if legs is not None and name not in WITH_LEGS:
        raise ConfigError("--legs", f"{name} has a fixed number of legs")
    if gait is not None and name != "bigant":
        raise ConfigError("--gait", f"{name} has one gait only; leave the option out")
    if robot_file is not None and name != "bigant":
        raise ConfigError("--robot", f"{name} is not read from a robot file")
    length = DEFAULT_CYCLES[name] if cycles is None else cycles
    if not 0 < length <= MOST_CYCLES:
        raise ConfigError("--cycles", f"must be above 0 and up to {MOST_CYCLES:g}, not {length:g}")
    if name == "bigant":
        robot = load_robot(DEFAULT_ROBOT_FILE if robot_file is None else robot_file)
        robot, named = with_gait(robot, gait)
        return bigant(robot.parameters, robot.name, named, length)
    if name in WITH_LEGS:
        make, usual = WITH_LEGS[name]
        return make(usual if legs is None else legs, cycles=length)
    if name == "stairs":
        return stairs.climb(cycles=length, law=law, tilt_coupling=tilt_coupling)
    frames = round(length / DEFAULT_CYCLES["quadruped"] * quadruped.FRAMES)
    return quadruped.quadruped(frames)


def bigant(robot: RobotParameters, robot_name: str, gait_name: str, cycles: float) -> System:
    """BigANT, or any robot with its file, walking straight ahead for so many cycles of a named gait.

    Raises:
        ConfigError: There is no such gait.
        ModelError: The motion is too short.
    """
    gait = make_gait(gait_name, robot)
    time_s = even_times(cycles / gait.frequency_hz)
    shafts = gait.motion(gait.start_phase + gait.frequency_hz * time_s, 0.0)
    feet = leg_kinematics(robot).feet(shafts.angle_rad, shafts.slope * gait.frequency_hz)
    hips = robot.legs.shaft_position[:, :2] * (1.0, SHAFT_SHARE)
    margin = np.array([BODY_MARGIN_M, 0.0])
    low, high = hips.min(axis=0) - margin, hips.max(axis=0) + margin
    return System(
        name="bigant",
        description=f"{robot_name}, {gait_name} gait, {gait.frequency_hz:g} Hz",
        time_s=time_s,
        feet=feet,
        contact=robot.contact,
        weight_n=robot.body.mass * STANDARD_GRAVITY,
        outline_B=np.array([high, [low[0], high[1]], low, [high[0], low[1]]]),
        hips_B=hips,
    )
