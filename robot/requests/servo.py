"""Requests of ``bigant servo``: the servos one by one."""

from pathlib import Path

from robot.console.arguments import (
    SERVO_ID,
    argument,
    as_json,
    baud_now,
    baud_rate,
    between,
    flag,
    hardware_port,
    id_or_all,
    needed,
    option,
    positive,
    request,
    robot_file,
    servo_port,
    virtual_robot,
)

BAUD_OF_ROBOT = "baud rate (robot file)"


@request("bringup.servo.setup:set_up")
class ServoSetupRequest:
    """``bigant servo setup``: bring servos into the settings of the robot file.

    Shows what differs in each servo's memory before anything is written (id, baud rate, return delay,
    operating mode, homing offset, limits, shutdown), asks, writes, reads back, and talks at the new baud
    rate. Refuses servos with torque on, and two servos with one id. A servo with an id that the robot
    file does not know gets the one that is missing, if it is the only one; otherwise connect one at a time.
    """

    port: str = servo_port()
    baud: int | None = baud_now()
    robot: Path = robot_file()
    id: int | None = option("this servo only", "N", type=SERVO_ID)
    new_id: int | None = option("its new id", "M", type=SERVO_ID)
    new_baud: int | None = option("new baud rate (default: robot file)", "B", type=baud_rate)
    yes: bool = flag("write without asking")


@request("bringup.servo.backup:back_up")
class ServoBackupRequest:
    """``bigant servo backup``: everything the servos keep, into a file.

    Reads all EEPROM registers and the gains of every servo that answers, with id, model, firmware and
    date, into a TOML file that ``bigant servo restore`` puts back. Writes nothing to any servo.
    """

    port: str = servo_port()
    baud: int | None = baud_now()
    out: Path = needed("a new .toml file", "FILE")


@request("bringup.servo.backup:restore")
class ServoRestoreRequest:
    """``bigant servo restore``: put a backup back.

    Shows what differs between the file and each servo, asks, writes with torque off, and reads back. A
    servo is found by its id; one of another model, or with torque on, is refused before anything is
    written.
    """

    path: Path = argument("FILE", "made by bigant servo backup")
    port: str = servo_port()
    baud: int | None = baud_now()
    yes: bool = flag("write without asking")


@request("bringup.servo.zero:zero")
class ServoZeroRequest:
    """``bigant servo zero``: the servo_zero line of the robot file.

    Turn every shaft by hand to shaft angle 0 (mid-stance), torque off, and run it. Takes the median of
    several readings, refuses shafts that move, and prints the line for the robot file. --robot-out writes a
    copy of the robot file with these zeros in it, --write a record of them with servo ids and models. No
    file that exists is ever changed.
    """

    port: str = servo_port()
    baud: int | None = baud_now(BAUD_OF_ROBOT)
    robot: Path = robot_file()
    robot_out: Path | None = option("the robot file with these zeros", "FILE")
    write: Path | None = option("zeros, servo ids, models (.toml)", "FILE")
    json: bool = as_json()


@request("bringup.servo.watch:watch_servos")
class ServoWatchRequest:
    """``bigant servo watch``: position, speed, current, voltage, temperature and errors, live.

    Only listens. A table that is redrawn on a terminal, one table a second anywhere else; at the end
    histograms of round trip and jitter and what went wrong on the wire. Ctrl-C ends it.
    """

    port: str = servo_port()
    baud: int | None = baud_now(BAUD_OF_ROBOT)
    robot: Path = robot_file()
    seconds: float | None = option("how long (until Ctrl-C)", "S", type=positive)
    rate_hz: int = option(
        "reads a second (50)", "R", default=50, type=between(1, 500, "Hz", whole=True)
    )
    json: bool = as_json("last readings and counts as JSON")


@request("bringup.servo.reboot:reboot")
class ServoRebootRequest:
    """``bigant servo reboot``: reboot servos, and keep what they are about to forget.

    Reads the hardware error and the turns first, reboots, waits until the servo is back, and checks that
    torque is off. Says what was lost. A servo with torque on drops its load, so this must be confirmed.
    """

    port: str = servo_port()
    baud: int | None = baud_now(BAUD_OF_ROBOT)
    id: int | None = needed("which servo", "N|all", type=id_or_all)
    robot: Path = robot_file()
    yes: bool = flag("also if it holds torque")
    json: bool = as_json()


@request("bringup.mapping.jog:jog")
class ServoJogRequest:
    """``bigant servo jog``: turn one leg a little and back, and find wrong ids, signs and zeros.

    For a robot that hangs in a frame, feet in the air. Only the servo that the robot file gives to the leg
    gets torque, for about three seconds; every goal goes through the safety gate. Afterwards it asks which
    leg moved and which way its foot went, and says how to change which line of the robot file. On real
    hardware it needs --armed. --virtual-robot is a virtual robot that differs from the robot file.
    """

    hardware: str = hardware_port()
    robot: Path = robot_file()
    virtual_robot: Path | None = virtual_robot()
    leg: str = option("leg to turn (all, in turn)", "LEG|all", default="all")
    deg: float = option("how far (10 deg)", "A", default=10.0, type=between(-20, 20, "deg"))
    armed: bool = flag("torque may be switched on")
    json: bool = as_json()
