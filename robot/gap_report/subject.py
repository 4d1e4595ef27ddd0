"""What was diagnosed: the machine, its joints, the day and the files, for the head of a report."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from record.trial.header import SERVO_BENCH
from record.trial.trial import Trial

SHOWN_FILES = 3


@dataclass(frozen=True, slots=True)
class Subject:
    """What was diagnosed.

    Attributes:
        machine: Its name, or that of its file.
        joints: Names of the joints, where each is a machine of its own; else empty.
        day: When the diagnosis was made.
        trials: Files of the trials.
        references: Files of the healthy runs.
    """

    machine: str
    joints: tuple[str, ...]
    day: date
    trials: tuple[Path, ...]
    references: tuple[Path, ...]

    @property
    def paths(self) -> tuple[Path, ...]:
        """All files, the references behind the trials."""
        return (*self.trials, *self.references)

    @property
    def place(self) -> str:
        """Machine and joints."""
        if not self.joints:
            return self.machine
        return f"{self.machine}, {'joint' if len(self.joints) == 1 else 'joints'} {', '.join(self.joints)}"


def subject_of(
    first: Trial, trials: Sequence[Path], references: Sequence[Path], day: date
) -> Subject:
    """Return what was diagnosed.

    Args:
        first: The first trial; all are of one machine.
        trials: Files of the trials.
        references: Files of the healthy runs.
        day: When the diagnosis was made.
    """
    header = first.header
    name = tomllib.loads(header.robot_text).get("name")
    joints = header.joints if header.kind == SERVO_BENCH else ()
    known = name if isinstance(name, str) else Path(header.robot_file).stem
    machine = known or header.kind.replace("_", " ")
    return Subject(machine, joints, day, tuple(trials), tuple(references))


def file_words(paths: Sequence[Path]) -> str:
    """Name the first few files, and say how many more there are."""
    shown = ", ".join(path.name for path in paths[:SHOWN_FILES])
    more = len(paths) - SHOWN_FILES
    return f"{shown} and {more} more" if more > 0 else shown
