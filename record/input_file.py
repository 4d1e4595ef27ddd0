"""Files that we read: never one that has no end, or on which reading waits for somebody who never writes.

What is refused is an ``OSError``, as is what the system refuses: callers need one sentence for both.
"""

import errno
import stat
from pathlib import Path
from typing import BinaryIO

LARGEST_TEXT = 10_000_000  # bytes; a robot file has 4,000


def open_file(path: Path) -> BinaryIO:
    """Open a file that may be of any size.

    Raises:
        OSError: It cannot be opened, or is no file: a pipe or a device.
    """
    _check_kind(path, files_only=True)
    return path.open("rb")


def read_bytes(path: Path, most: int = LARGEST_TEXT) -> bytes:
    """Return what is in a file that is small by its nature.

    Raises:
        OSError: It cannot be read, is a named pipe, or holds more than ``most`` bytes.
    """
    _check_kind(path, files_only=False)
    with path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most / 1e6:g} MB")
    return data


def read_utf8(path: Path) -> str:
    """Return the text of a file, line ends as they are.

    Raises:
        OSError: As ``read_bytes``, or it is no text.
    """
    try:
        return read_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise OSError(errno.EILSEQ, "it is not UTF-8 text") from error


def _check_kind(path: Path, *, files_only: bool) -> None:
    try:
        mode = path.stat().st_mode
    except ValueError as error:
        raise OSError(errno.EINVAL, "there is a NUL byte in its name") from error
    # <(a command) is a pipe, too, but one without a name: somebody writes to it
    if path.resolve().is_fifo() or (files_only and stat.S_ISFIFO(mode)):
        raise OSError(errno.EINVAL, "it is a pipe, not a file")
    if files_only and not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise OSError(errno.EINVAL, "it is a device, not a file")
