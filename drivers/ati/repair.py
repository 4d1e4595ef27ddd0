"""Reconnecting to a unit that has fallen silent, beside the loop: attempts with pauses that grow.

A unit that was switched off and on has forgotten its rate and needs its console again, which takes
seconds. That is done in a thread of its own; the loop only looks whether it is done.
"""

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass

from drivers.ati.calibration import Calibration
from drivers.ati.console import Console
from model.errors import ForceStreamError

FIRST_PAUSE_S = 1.0
LONGEST_PAUSE_S = 30.0

Background = Callable[[Callable[[], None]], None]


@dataclass(frozen=True, slots=True)
class Repaired:
    """A unit set up again.

    Attributes:
        console: The new console.
        calibrations: What the transducers' counts mean, read again.
    """

    console: Console
    calibrations: tuple[Calibration | None, ...]


def in_thread(work: Callable[[], None]) -> None:
    """Run work in a thread that does not keep the program alive."""
    threading.Thread(target=work, name="force unit repair", daemon=True).start()


class Repair:
    """Attempts to set the unit up again, one at a time.

    Args:
        attempt: Does it, and may take its time; raises ``ForceStreamError`` when it fails.
        background: Runs it where it holds nobody up.
    """

    def __init__(self, attempt: Callable[[], Repaired], background: Background = in_thread) -> None:
        self.attempts = 0
        self.last_error = ""
        self._attempt = attempt
        self._background = background
        self._done: queue.SimpleQueue[Repaired | ForceStreamError] = queue.SimpleQueue()
        self._running = False
        self._closed = False
        self._due_ns = 0
        self._pause_s = FIRST_PAUSE_S

    def begin(self, now_ns: int) -> None:
        """Begin an attempt if one is due and none is under way. Never waits."""
        if not self._running and now_ns >= self._due_ns:
            self._running = True
            self.attempts += 1
            self._background(self._work)

    def take(self, now_ns: int) -> Repaired | None:
        """Return the unit if an attempt has succeeded since the last call. Never waits."""
        try:
            outcome = self._done.get_nowait()
        except queue.Empty:
            return None
        self._running = False
        self._due_ns = now_ns + round(self._pause_s * 1e9)
        self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)
        if isinstance(outcome, ForceStreamError):
            self.last_error = str(outcome)
            return None
        return outcome

    def _work(self) -> None:
        try:
            repaired = self._attempt()
        except ForceStreamError as error:
            self._done.put(error)
            return
        except Exception as error:  # noqa: BLE001 - an attempt that says nothing would be the last
            self._done.put(ForceStreamError(f"{type(error).__name__}: {error}"))
            return
        self._done.put(repaired)
        if self._closed:
            repaired.console.close()

    def heard(self) -> None:
        """Records come again: the next silence starts with a short pause."""
        self._pause_s = FIRST_PAUSE_S

    def close(self) -> None:
        """Begin no more; an attempt under way gives its console back by itself."""
        self._closed = True
        self._due_ns = 2**63
        try:
            outcome = self._done.get_nowait()
        except queue.Empty:
            return
        if isinstance(outcome, Repaired):
            outcome.console.close()
