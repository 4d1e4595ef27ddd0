"""Faults of the data as a reader wants them: once for each kind and channel, not once for each file."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gap.diagnosis.findings import TrialFaults
from gap.interfaces import DataFault

SHOWN_FILES = 2


@dataclass(frozen=True, slots=True)
class FaultGroup:
    """One kind of fault in one channel.

    Attributes:
        kind: As the check of the data calls it.
        channel: Where.
        severe: Whether any of them is severe.
        files: Names of the files that have it, each once, in their order.
        evidence: What was seen in the first of them, of the severe ones if there are any.
    """

    kind: str
    channel: str
    severe: bool
    files: tuple[str, ...]
    evidence: str

    @property
    def where(self) -> str:
        """Which files, in few words."""
        shown = ", ".join(self.files[:SHOWN_FILES])
        more = len(self.files) - SHOWN_FILES
        return f"{shown} and {more} more" if more > 0 else shown


def fault_groups(faults: Sequence[TrialFaults], paths: Sequence[Path]) -> tuple[FaultGroup, ...]:
    """Return the groups: severe ones first, then those in most files.

    Args:
        faults: Of each trial, as a diagnosis holds them.
        paths: Files of the trials and the references, in their order.
    """
    found: dict[tuple[str, str], list[tuple[str, DataFault]]] = {}
    for one in faults:
        for fault in one.faults:
            same = found.setdefault((fault.kind, fault.channel), [])
            same.append((paths[one.trial].name, fault))
    groups = [
        FaultGroup(
            kind,
            channel,
            any(fault.severe for _, fault in same),
            tuple(dict.fromkeys(name for name, _ in same)),
            max(same, key=lambda named: named[1].severe)[1].evidence,
        )
        for (kind, channel), same in found.items()
    ]
    return tuple(sorted(groups, key=lambda group: (not group.severe, -len(group.files))))
