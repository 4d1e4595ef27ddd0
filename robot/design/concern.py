"""One thing that is wrong with a robot file, or worth knowing: why, and what to change."""

import enum
from dataclasses import dataclass


class Severity(enum.Enum):
    """How bad it is."""

    NOTE = "note"  # as it is, and perhaps as it is meant
    WARNING = "warning"  # the robot will walk badly, or is not the one that is meant
    IMPOSSIBLE = "impossible"  # there is no such robot, or it cannot stand


@dataclass(frozen=True, slots=True)
class Concern:
    """A judgement about a robot file.

    Attributes:
        severity: How bad it is.
        topic: One or two words, the same for the same kind of mistake: "tips", "drags", "units".
        place: Gait or key of the robot file that it is about.
        reason: What is so, with its numbers.
        advice: What to change; empty where nothing need be.
    """

    severity: Severity
    topic: str
    place: str
    reason: str
    advice: str = ""

    @property
    def line(self) -> str:
        """All of it in one line."""
        todo = f"; {self.advice}" if self.advice else ""
        return f"{self.place} {self.topic}: {self.reason}{todo}"


def warning(topic: str, place: str, reason: str, advice: str) -> Concern:
    """Return a warning."""
    return Concern(Severity.WARNING, topic, place, reason, advice)


def note(topic: str, place: str, reason: str, advice: str = "") -> Concern:
    """Return a note."""
    return Concern(Severity.NOTE, topic, place, reason, advice)


def impossible(topic: str, place: str, reason: str, advice: str) -> Concern:
    """Return what rules the robot out."""
    return Concern(Severity.IMPOSSIBLE, topic, place, reason, advice)
