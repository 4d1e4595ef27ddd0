"""Making a cut or damaged log whole again: everything that can be read, with index and summary."""

from dataclasses import dataclass
from pathlib import Path

from model.errors import RecordError
from record.log.rewrite import log_copy
from record.log.salvage import Damage, Pass, read_records


@dataclass(frozen=True, slots=True)
class Repair:
    """What a repair did.

    Attributes:
        kept: Number of messages in the new file.
        damages: What could not be read of the old one.
    """

    kept: int
    damages: tuple[Damage, ...]


def repair(path: Path, out: Path, progress: Pass | None = None) -> Repair:
    """Copy what can be read of a log into a proper file.

    Args:
        path: The log, cut, damaged or whole.
        out: The file to write.
        progress: Filled on the way.

    Raises:
        RecordError: Nothing can be read, or the file cannot be written.
    """
    done = progress if progress is not None else Pass()
    with log_copy(out, inputs=(path,)) as copy:
        for record in read_records(path, done):
            copy.add(record)
        if copy.messages == 0:
            raise RecordError(f"nothing in {path} can be read")
    return Repair(copy.messages, tuple(done.damages))
