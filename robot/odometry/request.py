"""What ``bigant odom`` is asked for, and what the estimator uses in place of a log's robot file."""

from dataclasses import replace

from model.errors import ConfigError
from model.quasistatic.frames import FrictionLaw
from record.whole_file import check_room
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.requests.recorded import TUNE, OdomRequest

SUFFIXES = (".tum", ".mcap", ".png", ".html")


def believed_robot(
    request: OdomRequest, own: str = "", robot: RobotConfig | None = None
) -> RobotConfig:
    """Return the robot to use.

    Args:
        request: What to use in place of a log's own robot file.
        own: The robot file in the log; without one the usual robot.
        robot: A robot file that is read already, in place of the request's.

    Raises:
        ConfigError: The robot file is none.
    """
    if robot is not None:
        config = robot
    elif request.robot is not None:
        config = load_robot(request.robot, driven=False)
    else:
        config = parse_robot(own) if own else load_robot()
    settings = config.estimator.settings
    if request.law is not None:
        settings = replace(settings, law=FrictionLaw(request.law))
    if request.no_sway:
        settings = replace(settings, sway=False)
    return replace(config, estimator=replace(config.estimator, enabled=True, settings=settings))


def check(request: OdomRequest) -> None:
    """Refuse what does not go together.

    Raises:
        ConfigError: Options that do not fit each other.
        RecordError: The file cannot be written.
    """
    live, several = request.live, len(request.logs) > 1
    beside = (request.hardware, request.force_unit, request.duration)
    suffix = "" if request.out is None else request.out.suffix
    kinds = (".tum",) if live else (".toml",) if request.tunes else SUFFIXES
    whole = "needs a whole log; leave --live out"
    rules = (
        (live and request.compare, "--compare", whole),
        (live and request.smooth, "--smooth", whole),
        (live and request.fitted is not None, "--fitted", whole),
        (live and request.html is not None, "--html", whole),
        (request.tunes and request.html is not None, "--html",
         "is not for odom tune; judge the file that it writes: bigant odom LOG --robot FILE --html ..."),
        (live and (several or request.logs == (TUNE,)), "LOG", "give one log to follow"),
        (live and request.logs and request.hardware is not None, "--live",
         "follows a LOG or reads --hardware PORT; give one of them"),
        (not live and any(option is not None for option in beside),
         "--hardware, --force-unit, --duration", "go with --live; add it"),
        (not live and not request.logs, "LOG", "is missing; name a log, or use --live"),
        (request.tunes and not several, "LOG", "odom tune needs at least one"),
        (several and not request.tunes, "LOG", "give one log; only 'odom tune' takes several"),
        (request.fitted is not None and not request.compare, "--fitted", "is for --compare; add it"),
        (request.out is not None and suffix not in kinds, "--out",
         f"must end in {', '.join(kinds[:-1])}{' or ' if kinds[1:] else ''}{kinds[-1]}, not "
         f"{request.out and request.out.name!r}"),
        (request.smooth and suffix != ".tum", "--smooth",
         "writes a trajectory; add --out FILE.tum"),
    )  # fmt: skip
    for broken, key, reason in rules:
        if broken:
            raise ConfigError(key, reason)
    check_room(request.out, "--out")
    check_room(request.html, "--html", ".html")
