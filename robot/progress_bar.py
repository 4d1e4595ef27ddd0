"""A bar on stderr for work whose share done is known; nothing before it has taken a second."""

import sys
import time
from types import TracebackType
from typing import Self

FIRST_S = 1.0
TERMINAL_S = 0.2
FILE_S = 10.0
WIDTH = 30


class ProgressBar:
    """Use as a context manager, and tell it the share done.

    Args:
        label: What is being done.
    """

    def __init__(self, label: str) -> None:
        self._label = label
        self._terminal = sys.stderr.isatty()
        self._start_s = time.monotonic()
        self._next_s = self._start_s + FIRST_S
        self._shown = 0

    def show(self, share: float, words: str = "") -> None:
        """Show the share done, 0 to 1, if it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s = now_s + (TERMINAL_S if self._terminal else FILE_S)
        left_s = (now_s - self._start_s) * (1 - share) / share if share > 0 else float("nan")
        left = f"{left_s:.0f} s left" if left_s == left_s else ""
        done = round(WIDTH * share)
        text = f"{self._label} [{'#' * done}{'.' * (WIDTH - done)}] {100 * share:3.0f} % {left} {words}"
        if self._terminal:
            print(f"\r{text.ljust(self._shown)}", end="", file=sys.stderr, flush=True)
            self._shown = len(text)
        else:
            print(text, file=sys.stderr, flush=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Clear the line."""
        if self._shown:
            print("\r" + " " * self._shown + "\r", end="", file=sys.stderr, flush=True)
