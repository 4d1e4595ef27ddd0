"""What a command leaves: lines for a reader who may be gone, and files that replace no earlier one."""

import contextlib
import os
import sys
from pathlib import Path

from model.errors import RecordError


def complain(line: str) -> None:
    """Print a line on stderr, if anybody is left to read it."""
    with contextlib.suppress(OSError):
        print(line, file=sys.stderr, flush=True)


def stop_output() -> None:
    """Point standard output to nowhere, so that its last flush cannot fail once more."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def keep_earlier(path: Path) -> Path | None:
    """Rename a file that a new one would overwrite, to ``NAME.1.mcap`` for example, and say so.

    Args:
        path: Where a new file is to be written.

    Returns:
        Its new name; None where there was nothing to keep.

    Raises:
        RecordError: It cannot be renamed.
    """
    if not path.is_file() or path.stat().st_size == 0:
        return None
    number = 1
    while (other := path.with_name(f"{path.stem}.{number}{path.suffix}")).exists():
        number += 1
    try:
        path.rename(other)
    except OSError as error:
        raise RecordError(
            f"{path} is there and cannot be kept as {other.name}: {error.strerror}; choose another name"
        ) from error
    complain(f"note: the earlier {path} is now {other}")
    return other
