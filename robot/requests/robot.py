"""Requests of ``bigant robot``: a robot file looked at, begun, and for other programs."""

from pathlib import Path

from robot.console.arguments import (
    DEFAULT_ROBOT_FILE,
    argument,
    as_json,
    option,
    request,
    robot_file,
)


@request("report.robot_show:show_robot", writes=True)
class RobotShowRequest:
    """``bigant robot show``: the robot of a file as the model walks it, and what is wrong with it.

    Walks each gait of the file through kinematics and the quasi-static model and prints speed, stance,
    static margin, tilt, clearance, slip, shaft speed and torque against their limits. Warns where the robot
    tips, drags, rocks, slides or saturates, and of numbers that no robot has, with what to change. Exit
    code 1: there is a warning.
    """

    robot: Path = argument(
        "FILE", "robot file (default: config/bigant.toml)", nargs="?", default=DEFAULT_ROBOT_FILE
    )
    gait: str | None = option(
        "only this gait, or the one of a Python file (default: all of them)", "NAME|FILE.py"
    )
    out: Path | None = option("also a page with pictures (.html), or the pictures (.png)", "FILE")
    json: bool = as_json("the figures over a cycle as JSON")


@request("config.xml:export", writes=True)
class RobotExportRequest:
    """``bigant robot export``: the robot file as URDF or MJCF.

    URDF is a tree: a crank joint (its value is the shaft angle) and a coupler joint a leg; the rocker that
    closes the loop is left out, so set the coupler as the robot file's linkage has it. MJCF has the rocker
    and closes the loop; its actuators hold shaft angles.
    """

    robot: Path = robot_file()
    urdf: Path | None = option("write a URDF", "OUT")
    mjcf: Path | None = option("write a MuJoCo model", "OUT")
