"""Missing machine code is made by two processes: this one, and one that begins with what comes last.

On a machine's first start half a minute goes into compiling, one kernel after another. Each finds what the
other has kept already (``model.kernel_cache``), so they meet in the middle.
"""

import multiprocessing
import os
import subprocess
import sys

from model.compile_notice import on_compiling

MODULE = "bigant.compile_ahead"


class SecondCompiler:
    """Is told by the compiler, and starts the second process when the first function is compiled."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self._asked = False

    def __call__(self, begins: bool) -> None:
        """Take one event: a compilation begins, or ends."""
        if begins and not self._asked:
            self._asked = True
            if multiprocessing.parent_process() is None and (os.cpu_count() or 1) > 1:
                self._start()

    def _start(self) -> None:
        # it leaves when its input ends, which it does when this process does
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-m", MODULE],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip
        except OSError:  # no room for another process: this one compiles everything
            self.process = None


_SECOND = SecondCompiler()


def compile_with_two() -> None:
    """From now on, compile what is missing with two processes."""
    on_compiling(_SECOND)
