"""Runs that a machine could make, so that the next one can be chosen among them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from gap.interfaces import Cause
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A run that could be made.

    Attributes:
        name: What to do, in words.
        trial: Its commands; nothing measured.
        minutes: How long it takes.
        limits: What to mind, in words; empty if nothing.
        known: What is done to the machine on purpose, such as a weight put on it.
        command: Command line that makes it; empty if there is none.
    """

    name: str
    trial: Trial
    minutes: float
    limits: str
    known: tuple[Cause, ...] = ()
    command: str = ""


class Proposer(Protocol):
    """Makes proposals for a machine."""

    def proposals(self) -> Sequence[Proposal]:
        """Return runs that this machine could make."""
        ...
