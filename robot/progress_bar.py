"""A bar on stderr that says what is being done and how much of it."""

import sys
import time
from types import TracebackType

FIRST_S = 1.0
TERMINAL_S = 0.1
# Where nobody watches a line change, a new line now and then is enough.
FILE_S = 10.0
WIDTH = 24


class ProgressBar:
    """Shows shares of a piece of work once it has taken a second."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._next_s = time.monotonic() + FIRST_S
        self._shown = 0

    def update(self, words: str, share: float) -> None:
        """Show what is being done, if it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s = now_s + (TERMINAL_S if self._terminal else FILE_S)
        full = round(WIDTH * min(max(share, 0.0), 1.0))
        text = f"[{'#' * full}{'.' * (WIDTH - full)}] {share:4.0%} {words}"
        if self._terminal:
            print("\r" + text.ljust(self._shown), end="", file=sys.stderr, flush=True)
            self._shown = max(self._shown, len(text))
        else:
            print(text, file=sys.stderr, flush=True)

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Clear the bar."""
        if self._shown:
            print("\r" + " " * self._shown + "\r", end="", file=sys.stderr, flush=True)
