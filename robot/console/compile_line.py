"""A line that says that the model is being compiled: the first run after a change waits for it."""

from model.compile_notice import tell_of_compiling
from robot.console.progress import StatusLine

LABEL = "compiling the model, first run only"


class CompileLine:
    """Hears of the compiler and shows how many functions are done; silent where nothing is compiled."""

    def __init__(self) -> None:
        self._line: StatusLine | None = None
        self._depth = 0
        self._done = 0

    def __call__(self, begins: bool) -> None:
        """Take one piece of news: a compilation begins, or ends."""
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
    tell_of_compiling(_LINE)
