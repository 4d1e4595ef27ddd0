"""Requests of ``bigant robot``: the robot file for other programs."""

from pathlib import Path

from robot.console.arguments import option, request, robot_file


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
