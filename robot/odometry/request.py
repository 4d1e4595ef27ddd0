"""What ``bigant odom`` is asked for, and what the estimator is to believe other than a log's robot file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from model.errors import ConfigError
from model.quasistatic.frames import FrictionLaw
from record.whole_file import check_room
from robot.config.robot_file import RobotConfig, load_robot, parse_robot

TUNE = "tune"
SUFFIXES = (".tum", ".mcap", ".png", ".html")


@dataclass(frozen=True, slots=True)
class OdomRequest:
    """What ``bigant odom`` was asked for; ``logs`` may begin with the word ``tune``.

    The first four say what to believe other than the log's own robot file says.
    """

    robot: Path | None = None
    law: str | None = None
    no_sway: bool = False
    no_forces: bool = False
    logs: Sequence[Path] = ()
    compare: bool = False
    fitted: Path | None = None
    smooth: bool = False
    out: Path | None = None
    live: bool = False
    hardware: str | None = None
    force_unit: str | None = None
    duration: float | None = None
    json: bool = False

    def config(self, own: str = "") -> RobotConfig:
        """Return the robot to believe in; ``own`` is the robot file in the log, if there is one.

        Raises:
            ConfigError: The robot file is none.
        """
        if self.robot is not None:
            config = load_robot(self.robot)
        else:
            config = parse_robot(own) if own else load_robot()
        settings = config.estimator.settings
        if self.law is not None:
            settings = replace(settings, law=FrictionLaw(self.law))
        if self.no_sway:
            settings = replace(settings, sway=False)
        return replace(config, estimator=replace(config.estimator, enabled=True, settings=settings))

    @property
    def tunes(self) -> bool:
        """Whether noise is to be found from logs."""
        return not self.live and list(self.logs[:1]) == [Path(TUNE)]

    def check(self) -> None:
        """Refuse what does not go together.

        Raises:
            ConfigError: Options that do not fit each other.
            RecordError: The file cannot be written.
        """
        live, several = self.live, len(self.logs) > 1
        beside = (self.hardware, self.force_unit, self.duration)
        suffix = "" if self.out is None else self.out.suffix
        kinds = (".tum",) if live else (".toml",) if self.tunes else SUFFIXES
        whole = "needs a whole log; leave --live out"
        rules = (
            (live and self.compare, "--compare", whole),
            (live and self.smooth, "--smooth", whole),
            (live and self.fitted is not None, "--fitted", whole),
            (live and (several or list(self.logs) == [Path(TUNE)]), "LOG", "give one log to follow"),
            (live and self.logs and self.hardware is not None, "--live",
             "follows a LOG or reads --hardware PORT; give one of them"),
            (not live and any(option is not None for option in beside),
             "--hardware, --force-unit, --duration", "go with --live; add it"),
            (not live and not self.logs, "LOG", "is missing; name a log, or use --live"),
            (self.tunes and not several, "odom tune", "needs a log to tune by; give at least one"),
            (several and not self.tunes, "LOG", "give one log; only 'odom tune' takes several"),
            (self.fitted is not None and not self.compare, "--fitted", "is for --compare; add it"),
            (self.out is not None and suffix not in kinds, "--out",
             f"must end in {', '.join(kinds[:-1])}{' or ' if kinds[1:] else ''}{kinds[-1]}, not "
             f"{self.out and self.out.name!r}"),
            (self.smooth and suffix != ".tum", "--smooth",
             "writes a trajectory; add --out FILE.tum"),
        )  # fmt: skip
        for broken, key, reason in rules:
            if broken:
                raise ConfigError(key, reason)
        check_room(self.out, "--out")
