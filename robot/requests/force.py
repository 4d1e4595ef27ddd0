"""Requests of ``bigant force``: the force-torque sensors."""

from pathlib import Path

from robot.console.arguments import (
    EITHER,
    argument,
    as_json,
    between,
    flag,
    option,
    positive,
    random_seed,
    request,
    robot_file,
    virtual_robot,
)

ADDRESS = "HOST[:UDP:CONSOLE]"


@request("bringup.force.watch:watch_forces", writes=True)
class ForceWatchRequest:
    """``bigant force watch``: what the force-torque unit sends, live.

    Per transducer forces and moments, state and age; for the stream its rate, losses and the unit's clock
    against the host's. The robot file's bias or a calibration is subtracted. Ctrl-C ends it; the unit's
    stream is always stopped on exit.
    """

    robot: Path = robot_file()
    force_unit: str | None = option("(default: robot file)", ADDRESS)
    seconds: float | None = option("stop after so many seconds", "S", type=positive)
    calibration: Path | None = option("calibration file to use", "FILE")
    csv: Path | None = option("write every sample", "FILE")
    json: bool = as_json("only the last reading, as JSON")


@request("bringup.force.bias:measure", writes=True)
class ForceBiasRequest:
    """``bigant force bias``: what the sensors read with no contact, measured on the host.

    Hang the robot up so that no foot touches anything. The mean over some seconds goes into a calibration
    file, with its standard error; the unit itself is not changed unless --device is given. Refused if the
    readings scatter or drift, as they do if something touches the robot.
    """

    robot: Path = robot_file()
    force_unit: str | None = option("(default: robot file)", ADDRESS)
    seconds: float = option("(default: 5)", "S", default=5.0, type=between(1, 3600))
    out: Path = option(
        "calibration file to write (default: force-bias.toml)",
        "FILE",
        default=Path("force-bias.toml"),
    )
    device_off: bool = flag(
        "first switch the unit's own BIAS off, which somebody may have left on", group=EITHER
    )
    device: bool = flag(
        "also switch the unit's own BIAS on for every transducer (it then counts from zero, so the file "
        "holds zeros measured after that)",
        group=EITHER,
    )
    json: bool = as_json()


@request("bringup.force.calibrate:calibrate", writes=True)
class ForceCalibrateRequest:
    """``bigant force calibrate``: force sensors to foot wrenches, from logs of a robot at rest.

    Stage one fits what each sensor reads with its foot in the air (offset and leg gravity over the shaft
    angle), stage two a 6 x 6 correction from poses in which the feet carry the weight. Poses are found in
    the logs where no shaft moves. Tested on held-out poses; nothing is written if their error increased.
    --hardware virtual drives the virtual robot through such poses first, in virtual time.
    """

    logs: tuple[Path, ...] = argument("LOG", "robot standing at rest", nargs="*", default=())
    hung: tuple[Path, ...] = option(
        "logs of the robot hung up, no foot on the ground", "LOG", nargs="+", default=()
    )
    hardware: str | None = option("record poses first", choices=("virtual",))
    rounds: int = option(
        "with --hardware: number of times each leg is lifted (4)",
        "N",
        default=4,
        type=between(1, 50, whole=True),
    )
    seed: int = random_seed("with --hardware")
    log: Path = option(
        "with --hardware: the log to write (ft-poses.mcap)", "FILE", default=Path("ft-poses.mcap")
    )
    robot: Path | None = option(
        "robot file (default: with --hardware config/bigant.toml, else the one in the logs)", "FILE"
    )
    harmonics: int = option(
        "most harmonics of leg gravity (3)", "H", default=3, type=between(0, 8, whole=True)
    )
    no_cross_talk: bool = flag("stage one only")
    no_point_feet: bool = flag("do not assume that feet touch at a point")
    out: Path = option(
        "calibration file (force-calibration.toml)", "FILE", default=Path("force-calibration.toml")
    )
    report: Path | None = option("picture, .png", "FILE")
    json: bool = as_json("residuals and warnings as JSON")


@request("bringup.mapping.identify:identify")
class ForceIdentifyRequest:
    """``bigant force identify``: press each foot, and see which transducer feels it and how it is turned.

    For a robot that hangs in a frame, torque off. Each foot is pressed up, forward and to the robot's
    left, with about 1 kg; the beginning and the end of a press are detected. Gives each leg's transducer,
    whether it is mounted the right way up, and its yaw, and says how to change which line of the robot
    file. With --hardware virtual, a virtual person presses the feet of a virtual robot; --virtual-robot
    makes it differ from the robot file.
    """

    hardware: str | None = option("a virtual robot and its unit", choices=("virtual",))
    force_unit: str | None = option("wireless unit (robot file)", ADDRESS)
    robot: Path = robot_file()
    virtual_robot: Path | None = virtual_robot()
    leg: str = option("foot to press (all)", "LEG|all", default="all")
    json: bool = as_json()
