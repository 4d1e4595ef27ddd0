"""How far a long piece of work is, on stderr, once it has taken a second."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from model.compile_notice import on_compiling
from robot.console.printable import printable
from robot.console.screen_fit import shortened, terminal_size

if TYPE_CHECKING:  # importing it takes 50 ms of every --help
    from record.log.damage import Pass

FIRST_S = 1.0
TERMINAL_S = 0.2
# Where nobody watches a line change, a new line now and then is enough.
FILE_S = 10.0
WIDTH = 30


class StatusLine:
    """One line that changes on a terminal and is written now and then anywhere else; a context manager."""

    def __init__(self, label: str = "") -> None:
        self._label = label
        self._terminal = sys.stderr.isatty()
        self._start_s = time.monotonic()
        self._next_s = self._start_s + FIRST_S
        self._shown = 0

    def say(self, text: str) -> None:
        """Show a text, if it is time to."""
        if self.is_time():
            self._show(text)

    def step(self, text: str) -> None:
        """Show on a terminal at once what is being done."""
        if self._terminal:
            self._show(text)

    def clear(self) -> None:
        """Take the line away again."""
        if self._shown:
            print("\r" + " " * self._shown + "\r", end="", file=sys.stderr, flush=True)
            self._shown = 0

    def is_time(self) -> bool:
        """Whether to show something now; the next time is then set."""
        now_s = time.monotonic()
        if now_s < self._next_s:
            return False
        self._next_s = now_s + (TERMINAL_S if self._terminal else FILE_S)
        return True

    def _show(self, text: str) -> None:
        if self._terminal:
            # a line that wraps cannot be written over; the last column is left free for the cursor
            text = shortened(printable(text), terminal_size(sys.stderr).columns - 1)
            print(f"\r{text.ljust(self._shown)}", end="", file=sys.stderr, flush=True)
            self._shown = len(text)
        else:
            print(printable(text), file=sys.stderr, flush=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Clear the line."""
        self.clear()


class ProgressLine(StatusLine):
    """A line that says how far the reading of a log is.

    Args:
        label: What is being done.
        progress: Filled by the reader.
    """

    def __init__(self, label: str, progress: "Pass") -> None:
        super().__init__(label)
        self._progress = progress
        progress.tell = self.update

    def update(self) -> None:
        """Show how far it is, if it is time to."""
        if self._progress.size > 0 and self.is_time():
            share = f": {100 * self._progress.position // self._progress.size} %"
            room = terminal_size(sys.stderr).columns - 1 - len(share)
            self._show((shortened(self._label, room) if self._terminal else self._label) + share)


class ProgressBar(StatusLine):
    """A bar for work whose share done is known, with the time that is left.

    Args:
        label: What is being done.
    """

    def show(self, share: float, words: str = "") -> None:
        """Show the share done, 0 to 1, if it is time to."""
        if not self.is_time():
            return
        done = round(WIDTH * share)
        bar = "#" * done + "." * (WIDTH - done)
        left = ""
        if share > 0:
            left_s = (time.monotonic() - self._start_s) * (1 - share) / share
            left = f"{left_s:.0f} s left"
        self._show(f"{self._label} [{bar}] {100 * share:3.0f} % {left} {words}".rstrip())

    def tell(self, words: str, share: float) -> None:
        """Show the share done, as a diagnosis reports it."""
        self.show(share, words)


LABEL = "compiling the model, first run only"


class CompileLine:
    """Is told by the compiler and shows how many functions are done; silent where nothing is compiled."""

    def __init__(self) -> None:
        self._line: StatusLine | None = None
        self._depth = 0
        self._done = 0

    def __call__(self, begins: bool) -> None:
        """Take one event: a compilation begins, or ends."""
        if self._line is None:
            self._line = StatusLine()
        self._depth += 1 if begins else -1
        self._done += not begins
        if self._depth == 0:
            self._line.clear()
        else:
            self._line.say(f"{LABEL}: {self._done} functions done")


_LINE = CompileLine()


def show_compiling() -> None:
    """From now on, show it on stderr."""
    on_compiling(_LINE)
