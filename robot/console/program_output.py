"""Lines for a reader who may be gone."""

import contextlib
import os
import sys

from robot.console.printable import printable


def complain(line: str) -> None:
    """Print a line on stderr, if anybody is left to read it."""
    with contextlib.suppress(OSError):
        print(printable(line), file=sys.stderr, flush=True)


def tell(text: str) -> None:
    """Print for a reader who may be gone, as with ``| head``: what else there is to do goes on."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        stop_output()


def stop_output() -> None:
    """Point standard output to nowhere, so that its last flush cannot fail once more."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
