"""Files that we write: refused before any work is done for them, or there only when they are whole."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from model.errors import ConfigError, RecordError


@contextmanager
def writing(path: Path, option: str = "--out") -> Iterator[None]:
    """Say which file cannot be written, and which option chose it, where the block fails to.

    Raises:
        RecordError: The block raised an ``OSError``.
    """
    try:
        yield
    except OSError as error:
        why = error.strerror or str(error).rpartition("] ")[2]  # Arrow's words: [errno 2] why
        raise RecordError(f"{path} cannot be written: {why}; choose another {option}") from error


@contextmanager
def whole_file(out: Path, option: str = "--out") -> Iterator[Path]:
    """Yield the name to write to; it becomes ``out`` at the end, and is removed if the block fails.

    Args:
        out: Where the file is to be. What is there stays until then.
        option: Option that names it.

    Raises:
        RecordError: It cannot be written.
    """
    # of this process alone, and with the suffix that tells writers the kind
    part = out.with_name(f".{out.stem}.{os.getpid()}.part{out.suffix}")
    try:
        with writing(out, option):
            yield part
            part.replace(out)
    finally:
        with suppress(OSError):  # there may never have been one
            part.unlink()


def write_text(path: Path, text: str, option: str = "--out") -> None:
    """Write a text.

    Raises:
        RecordError: It cannot be written.
    """
    with writing(path, option):
        path.write_text(text, encoding="utf-8")


def check_room(path: Path | None, option: str, *suffixes: str) -> None:
    """Refuse, before any work is done for it, an output that cannot be written.

    Args:
        path: The file to be; None for none.
        option: Option that names it.
        suffixes: What its name may end in; anything without them.

    Raises:
        ConfigError: It ends in something else.
        RecordError: It is a folder, its folder is not there, or one of them may not be written to.
    """
    if path is None:
        return
    if suffixes and path.suffix not in suffixes:
        *some, last = suffixes
        kinds = f"{', '.join(some)} or {last}" if some else last
        raise ConfigError(option, f"must end in {kinds}, not {path.suffix or path.name!r}")
    if path.is_dir():
        raise RecordError(f"{option} {path} is a folder; name a file")
    if not path.parent.is_dir():
        raise RecordError(f"{option} {path}: there is no folder {path.parent}; make it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise RecordError(f"{option} {path} may not be written; choose another")
