"""``bigant robot export``: the robot file as URDF or MJCF.

URDF is a tree: a crank joint (its value is the shaft angle) and a coupler joint a leg; the rocker that
closes the loop is left out, so set the coupler as the robot file's linkage has it. MJCF has the rocker and
closes the loop; its actuators hold shaft angles.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--urdf", type=Path, metavar="OUT", help="write a URDF")
    parser.add_argument("--mjcf", type=Path, metavar="OUT", help="write a MuJoCo model")


def run(options: argparse.Namespace) -> ExitCode:
    """Write the files, and see that MuJoCo loads them.

    Raises:
        ConfigError: Nothing is asked for, or a file cannot be written.
    """
    import mujoco

    from model.errors import ConfigError
    from robot.config.robot_file import load_robot
    from robot.config.xml import mjcf_text, urdf_text

    if options.urdf is None and options.mjcf is None:
        raise ConfigError("--urdf", "or --mjcf must say what to write")
    config = load_robot(options.robot)
    for path, make in ((options.urdf, urdf_text), (options.mjcf, mjcf_text)):
        if path is None:
            continue
        text = make(config.name, config.parameters)
        model = mujoco.MjModel.from_xml_string(text)
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ConfigError(str(path), f"cannot be written: {error.strerror}") from error
        mass = float(model.body_mass.sum())
        print(f"{path}: {model.njnt} joints, {mass:.3f} kg; MuJoCo loads it")
    return ExitCode.OK
