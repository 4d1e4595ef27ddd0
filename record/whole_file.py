"""A file that is there only when it is whole: written beside its place, and moved there at the end.

And one that cannot be written is refused before any work is done for it.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from model.errors import RecordError


@contextmanager
def whole_file(out: Path) -> Iterator[Path]:
    """Yield the name to write to; it becomes ``out`` at the end, and is removed if the block fails.

    Args:
        out: Where the file is to be. What is there stays until then.
    """
    part = out.with_name(f".{out.stem}.part{out.suffix}")  # the suffix tells writers the kind
    try:
        yield part
        part.replace(out)
    finally:
        with suppress(OSError):  # there may never have been one
            part.unlink()


@contextmanager
def writing(path: Path, option: str = "--out") -> Iterator[None]:
    """Turn what the system refuses into an error that says what to do.

    Args:
        path: The file that is written.
        option: Option that names it.

    Raises:
        RecordError: The file cannot be written.
    """
    try:
        yield
    except OSError as error:
        reason = (
            error.strerror or str(error).rpartition("] ")[2]
        )  # Arrow's words end: [errno 2] why
        raise RecordError(f"{path} cannot be written: {reason}; choose another {option}") from error


def check_room(path: Path | None, option: str) -> None:
    """Refuse, before any work is done for it, an output that cannot be written.

    Args:
        path: The file to be; None for none.
        option: Option that names it.

    Raises:
        RecordError: It is a folder, its folder is not there, or one of them may not be written to.
    """
    if path is None:
        return
    if path.is_dir():
        raise RecordError(f"{option} {path} is a folder; name a file")
    if not path.parent.is_dir():
        raise RecordError(f"{option} {path}: there is no folder {path.parent}; make it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise RecordError(f"{option} {path} may not be written; choose another")
