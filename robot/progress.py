"""How far a long piece of work is, on stderr, once it has taken a second."""

import sys
import time
from types import TracebackType

from record.salvage import Pass

FIRST_S = 1.0
TERMINAL_S = 0.2
# Where nobody watches a line change, a new line now and then is enough.
FILE_S = 10.0


class ProgressLine:
    """A line that says how far the reading of a log is.

    Args:
        label: What is being done.
        progress: Filled by the reader.
    """

    def __init__(self, label: str, progress: Pass) -> None:
        self._label = label
        self._progress = progress
        self._terminal = sys.stderr.isatty()
        self._next_s = time.monotonic() + FIRST_S
        self._shown = False
        progress.tell = self.update

    def update(self) -> None:
        """Show how far it is, if it is time to."""
        now_s = time.monotonic()
        if now_s < self._next_s or self._progress.size == 0:
            return
        self._next_s = now_s + (TERMINAL_S if self._terminal else FILE_S)
        percent = 100 * self._progress.position // self._progress.size
        text = f"{self._label}: {percent} %"
        if self._terminal:
            print(f"\r{text}  ", end="", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)
        self._shown = True

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Clear the line."""
        if self._shown and self._terminal:
            print("\r" + " " * (len(self._label) + 9) + "\r", end="", file=sys.stderr, flush=True)
