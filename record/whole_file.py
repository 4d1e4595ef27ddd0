"""Files that we write: refused before any work is done for them, or there only when they are whole."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from model.errors import ConfigError, RecordError
from record.earlier_file import keep_earlier, same_content


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

    What was there before stays if it is the same, and is kept under another name if it is not
    (``record.earlier_file``). A device is written to as it is. A block that removes its file leaves
    what is there.

    Args:
        out: Where the file is to be. What is there stays until then.
        option: Option that names it.

    Raises:
        RecordError: It cannot be written.
    """
    _check_no_pipe(out, option)
    if out.exists() and not out.is_file():
        with writing(out, option):
            yield out
        return
    # of this process alone, and with the suffix that tells writers the kind
    part = out.with_name(f".{out.stem}.{os.getpid()}.part{out.suffix}")
    try:
        with writing(out, option):
            part.touch()  # here, so that what fails is named by the name that was chosen
            yield part
            if part.exists() and not same_content(part, out):
                keep_earlier(out)
                part.replace(out)
    finally:
        with suppress(OSError):  # there may never have been one
            part.unlink()


def clear_name(path: Path, option: str = "--out") -> None:
    """Make room for a file that grows where it is: what is there is kept under another name.

    Raises:
        RecordError: It cannot be kept, or is a pipe.
    """
    _check_no_pipe(path, option)
    keep_earlier(path)


def _check_no_pipe(path: Path, option: str) -> None:
    """Refuse a named pipe: opening it would wait until somebody reads it, which may be never."""
    if path.resolve().is_fifo():
        raise RecordError(f"{path} is a pipe; name a file with {option}")


def write_text(path: Path, text: str, option: str = "--out") -> None:
    """Write a text as a whole file, line ends as they are.

    Raises:
        RecordError: It cannot be written.
    """
    with whole_file(path, option) as part:
        part.write_text(text, encoding="utf-8", newline="")


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
