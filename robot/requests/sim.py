"""Requests of ``bigant sim``: virtual hardware, and a deliberately faulty virtual robot."""

from pathlib import Path

from robot.console.arguments import (
    argument,
    as_json,
    baud_now,
    between,
    flag,
    gait_choice,
    needed,
    option,
    positive,
    random_seed,
    request,
    robot_file,
    scenario_file,
    several,
)


@request("virtual.serve:serve_robot")
class SimServeRequest:
    """``bigant sim serve``: virtual devices on a pseudo-terminal and loopback sockets until Ctrl-C.

    Serve a virtual robot that any Dynamixel or WNet program can talk to, and print where to find it. Ctrl-C
    ends it.
    """

    robot: Path = robot_file()
    seed: int = random_seed()
    baud: int | None = baud_now("baud rate of the servos")
    absent: tuple[int, ...] = several("a servo to leave out", "ID")
    no_force_unit: bool = flag("leave out the force unit")
    scenario: Path | None = scenario_file()


@request("virtual.listing:list_faults")
class SimFaultsRequest:
    """``bigant sim faults``: every fault and setting that a scenario file can hold.

    List the faults that a scenario file (--scenario of drive and sim serve) can put on the virtual
    hardware: what each does, where it acts, and its keys with unit, default and bounds.
    examples/faults_servo.toml and examples/faults_force.toml show them in use.
    """

    json: bool = as_json("the list as JSON")


@request("virtual.listing:list_effects")
class SimEffectsRequest:
    """``bigant sim effects``: what can be wrong with the virtual robot.

    A table of all effects with their parameters, units and ranges, and where each acts. Each has a mild
    and a strong size; `bigant sim run --effect NAME` uses the strong one. Effects marked * are not in the
    catalogue of the diagnosis.
    """

    json: bool = as_json("the list as JSON")


@request("virtual.listing:list_realities")
class SimRealitiesRequest:
    """``bigant sim realities``: the variants of the virtual robot.

    A reality is a variant of the virtual robot. Lists all of them and how each differs from the usual one:
    servo loop, gears, contact, legs, chassis, sensors, days, other robots. `bigant sim run --reality NAME`
    makes a run of one, `bigant campaign make --reality NAME` a campaign. drawn-N, for any whole number N,
    combines parts of the others at random.
    """

    json: bool = as_json("the list as JSON")


@request("virtual.twin_file:twin_file", writes=True)
class SimRunRequest:
    """``bigant sim run``: one walk of a virtual robot with chosen faults, as a trial or a log.

    The whole stack runs in virtual time: controller, servo bus and force unit, byte by byte. --fast leaves
    the bytes out and gives the same trial in a fraction of the time. FILE.parquet and FILE.csv are trials
    (the walk, with FILE.toml and the robot file next to it), FILE.mcap is a log of the whole run. The seed
    also sets the day: friction, stiffness and centre of mass differ by a few per cent from seed to seed.
    """

    robot: Path = robot_file()
    gait: str | None = gait_choice()
    frequency_hz: float | None = option(
        "cycles a second (default: the robot file's)", "F", type=positive
    )
    seconds: float = option("of walking (default: 30)", "S", default=30.0, type=positive)
    steer: float = option("-1 (right) to 1 (left)", "X", default=0.0, type=between(-1, 1))
    effect: tuple[str, ...] = several(
        "a fault; may be repeated (bigant sim effects lists them)",
        "NAME[@LEG][:param=value,...]",
    )
    reality: str = option(
        "variant of the virtual robot (bigant sim realities lists them; default: usual)",
        "NAME",
        default="usual",
    )
    seed: int = random_seed(None)
    out: Path = needed(".parquet, .csv or .mcap", "FILE")
    fast: bool = flag("without the byte layer; no .mcap")
    json: bool = as_json("what was done as JSON")


@request("view.film:render", writes=True)
class SimRenderRequest:
    """``bigant sim render``: a picture or video of a trial or a log, off-screen.

    Body, legs, paths, forces and slip as `bigant show LOG --video` draws them, here from the poses that a
    trial holds. Nothing is simulated, and no display or graphics card is needed. .png is one moment (--at),
    .gif and .mp4 are videos.
    """

    path: Path = argument("TRIAL|LOG")
    out: Path = needed(".png, .gif or .mp4", "FILE")
    at: float | None = option("moment of a .png (default: the middle)", "S")
    speed: float = option(
        "times real time of a video (default: 4)", "X", default=4.0, type=positive
    )
