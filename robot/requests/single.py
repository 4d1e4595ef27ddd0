"""Requests of the commands of one word about a robot or this computer: ``bigant drive`` and others."""

from pathlib import Path

from robot.console.arguments import (
    EITHER,
    argument,
    as_json,
    baud_now,
    between,
    discovery,
    file_name,
    flag,
    gait_choice,
    hardware_port,
    option,
    positive,
    random_seed,
    request,
    robot_file,
    scenario_file,
    virtual_robot,
)

VIRTUAL = "virtual"
LAST_STEP = 13  # of the first day
SHELLS = ("bash", "zsh", "fish")
UNIT_OR_NONE = "HOST[:UDP:CONSOLE]|none"
FROM_ROBOT_FILE = "force-torque unit (default: robot file)"


@request("drive.drive:drive", writes=True)
class DriveRequest:
    """``bigant drive``: walk a gait and keep a log.

    Virtual hardware is the default. Real ports are only listened to unless --armed is given. Ctrl-C stops
    on all feet, a second Ctrl-C cuts torque; torque is always switched off on exit.
    """

    robot: Path = robot_file()
    gait: str | None = gait_choice()
    cycles: float | None = option("gait cycles (default: 3)", "N", type=positive, group=EITHER)
    duration_s: float | None = option(
        "seconds of walking", "S", flags=("--duration",), type=positive, group=EITHER
    )
    frequency_hz: float | None = option("cycles a second (default: robot file)", "F", type=positive)
    steer: float = option("-1 (right) to 1 (left)", "X", default=0.0, type=between(-1, 1))
    hardware: str = option(
        "virtual (default), or the serial port of the servo bus, for example /dev/ttyUSB0",
        "virtual|PORT",
        default=VIRTUAL,
    )
    force_unit: str | None = option(
        "wireless force-torque unit (default: robot file); none walks without it", UNIT_OR_NONE
    )
    calibration: Path | None = option(
        "calibration of the force sensors (default: the one that the robot file names, if any)",
        "FILE",
    )
    log: str | None = option("log file, or none (default: runs/...)", "FILE", type=file_name)
    record_bytes: bool = flag(
        "log the raw bytes of both devices as well, so that the drivers can be replayed"
    )
    pose_udp: int | None = option(
        "receive absolute poses on this local UDP port (default: robot file, else none)",
        "PORT",
        type=between(1, 65535, whole=True),
    )
    imu: str | None = option(
        "receive an IMU on this local UDP port, or on a serial port (default: robot file, else none); "
        "none ignores it",
        "UDP|PORT|none",
    )
    readonly: bool = flag("read and log, never move")
    armed: bool = flag("allow torque on real hardware")
    teleop: bool = flag("drive with the keyboard")
    deadman_s: float = option(
        "with --teleop: stand after so many seconds without a key (default: 5)",
        "S",
        default=5.0,
        flags=("--deadman",),
        type=positive,
    )
    rate_hz: int | None = option(
        "loop rate, up to 200", "R", type=between(10, 200, "Hz", whole=True)
    )
    virtual_time: bool = flag(
        "virtual hardware in memory with a virtual clock: as fast as the computer can, and the same log, "
        "byte for byte, every time"
    )
    seed: int = random_seed()
    scenario: Path | None = scenario_file()

    @property
    def virtual(self) -> bool:
        """Whether the robot is a virtual one."""
        return self.hardware == VIRTUAL


@request("bringup.preflight.devices:list_devices")
class DevicesRequest:
    """``bigant devices``: ports, servos at each baud rate, force-torque units.

    List serial ports, the servos that answer at each baud rate, and wireless force-torque units found by
    discovery. Nothing is written and nothing moves.
    """

    port: str | None = option(
        "serial port, for example /dev/ttyUSB0 (default: every USB port); none: force-torque units only",
        "PORT|none",
    )
    baud: int | None = baud_now()
    discover: str = discovery()
    json: bool = as_json()


@request("cli.completion:completion")
class CompletionRequest:
    """``bigant completion``: a script that lets the shell complete commands, options, choices and files.

    Prints it. Its first lines and docs/howto.md say where to put it. Writing the script needs shtab (the
    extra bigant[completion]), using it does not.
    """

    shell: str = argument("SHELL", ", ".join(SHELLS), choices=SHELLS)


@request("cli.copies:copy_examples", writes=True)
class ExamplesRequest:
    """``bigant examples``: robot files and scripts that come with the program, listed or copied.

    Without names, all of them. Copies keep the project's folders (config/, examples/), so that commands
    copied from the documentation find them.
    """

    names: tuple[str, ...] = argument(
        "NAME", "such as octopod.toml, or config", nargs="*", default=()
    )
    out: Path | None = option("copy them into this folder", "FOLDER")
    json: bool = as_json()


@request("bringup.preflight.check:check", writes=True)
class CheckRequest:
    """``bigant check``: the pre-flight list. Is this robot fit to walk?

    Only reads, except with --armed and on virtual hardware: then torque is switched on at the measured
    positions, to prove that the servos' own watchdog switches it off again. Nothing is commanded to move.
    --computer checks this computer instead: versions, optional packages, disk, serial ports and their
    permissions, latency timers, real-time settings, the compiler's cache and OpenGL; no device is used.
    """

    hardware: str = hardware_port()
    force_unit: str | None = option(
        "wireless force-torque unit (robot file); none leaves it out", UNIT_OR_NONE
    )
    robot: Path = robot_file()
    armed: bool = flag("torque on, holding still, to prove the watchdog")
    computer: bool = flag("check this computer, and no robot")
    loop: float | None = option(
        "also run the loop without torque and report its lateness (10 s)",
        "S",
        nargs="?",
        const=10.0,
        type=between(0.5, 3600, "s"),
    )
    json: bool = as_json()
    html: Path | None = option("the list as one page, to keep", "FILE")


@request("bringup.first_day.bringup:bring_up")
class BringupRequest:
    """``bigant bringup``: the first day with a real robot, step by step.

    Thirteen numbered steps for a robot that hangs in a frame: which devices answer, the servos' stored
    settings, each leg by ten degrees, torque, watchdog, reboots, the loop, an unplugged cable, each foot
    pressed, the force unit's console, one cycle in the air, one on the floor. Each step says what it will
    do, asks, records every byte, gives a verdict, and is added to one page. The same command continues
    where it stopped. What the steps find out about the devices is written to measured.toml, a scenario
    file for virtual devices. Without --armed nothing moves. With virtual devices (the default) a virtual
    person does what a person would, in virtual time. docs/first_day.md is a page to print for the lab.
    """

    folder: Path = option(
        "state, page, logs and measured.toml (bringup)", "FOLDER", default=Path("bringup")
    )
    hardware: str = hardware_port()
    force_unit: str | None = option(
        "wireless force-torque unit (robot file); none leaves it out", UNIT_OR_NONE
    )
    robot: Path = robot_file()
    armed: bool = flag("torque may be switched on")
    yes: bool = flag("do not ask before steps that move and set nothing")
    begin: int | None = option(
        "begin with this step", "N", flags=("--from",), type=between(1, LAST_STEP, whole=True)
    )
    only: int | None = option("do this step only", "N", type=between(1, LAST_STEP, whole=True))
    list: bool = flag("list the steps and stop")
    seconds: float | None = option(
        "how long the loop runs in step 8 (600; virtual: 10)", "S", type=between(1, 36000, "s")
    )
    reboots: int | None = option(
        "reboots of each servo in step 7 (10; virtual: 3)", "N", type=between(1, 100, whole=True)
    )
    virtual_robot: Path | None = virtual_robot()
    scenario: Path | None = scenario_file()
    seed: int = random_seed("of virtual devices")
    ask: bool = flag("virtual hardware: you answer, its hands are simulated")
