"""Requests of ``bigant robot``: a robot file looked at, begun, and for other programs."""

from pathlib import Path

from robot.console.arguments import (
    DEFAULT_ROBOT_FILE,
    argument,
    as_json,
    between,
    file_name,
    option,
    request,
    robot_file,
)

LEAST_LEGS, MOST_LEGS = 4, 24


@request("report.robot_show:show_robot", writes=True)
class RobotShowRequest:
    """``bigant robot show``: the robot of a file as the model walks it, and what is wrong with it.

    Walks each gait of the file through kinematics and the quasi-static model and prints speed, stance,
    static margin, tilt, clearance, slip, shaft speed and torque against their limits. Warns if the robot
    tips, drags, rocks, slides or saturates, and of implausible values, and says what to change. Exit code
    1: there is a warning.
    """

    robot: Path = argument(
        "FILE", "robot file (default: config/bigant.toml)", nargs="?", default=DEFAULT_ROBOT_FILE
    )
    gait: str | None = option(
        "only this gait, or the one of a Python file (default: all of them)", "NAME|FILE.py"
    )
    out: Path | None = option("also a page with pictures (.html), or the pictures (.png)", "FILE")
    json: bool = as_json("the figures over a cycle as JSON")


@request("design.new_robot:new_robot", writes=True)
class RobotNewRequest:
    """``bigant robot new``: begin a robot file.

    Writes a commented file of a robot that stands about its centre of mass and walks, with the servo's own
    limits, gaits that suit the number of legs, and every value that is a stand-in marked as assumed. On a
    terminal it asks for what no option gives; otherwise the default is used.
    """

    name: str | None = option("name of the robot (Robot)", "NAME", type=file_name)
    legs: int | None = option(
        "number of legs (6)", "N", type=between(LEAST_LEGS, MOST_LEGS, whole=True)
    )
    leg: str | None = option("kind of leg (four_bar)", choices=("four_bar", "crank"))
    servo: str | None = option("model of the servos (MX-106(2.0))", "MODEL")
    leg_length: float | None = option(
        "foot below shaft in mid-stance, m", "M", type=between(0.005, 5, "m")
    )
    length: float | None = option("hind feet to front feet, m", "M", type=between(0.005, 5, "m"))
    width: float | None = option("left feet to right feet, m", "M", type=between(0.005, 5, "m"))
    mass: float | None = option("total mass, kg", "KG", type=between(0.02, 200, "kg"))
    force_sensors: str | None = option("force sensors in the legs (none)", choices=("none", "ati"))
    out: Path | None = option("the file (default: NAME.toml)", "FILE")


@request("config.xml:export", writes=True)
class RobotExportRequest:
    """``bigant robot export``: the robot file as URDF or MJCF.

    URDF is a tree: a crank joint (its value is the shaft angle) and a coupler joint a leg; the rocker that
    closes the loop is left out, so set the coupler's angle to match the robot file's linkage. MJCF has the
    rocker and closes the loop; its actuators hold shaft angles.
    """

    robot: Path = robot_file()
    urdf: Path | None = option("write a URDF", "OUT")
    mjcf: Path | None = option("write a MuJoCo model", "OUT")
