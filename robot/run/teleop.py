"""Driving from the keyboard, in a terminal, over SSH: no X server, no extra package.

A terminal reports presses and never releases. So a press is also a sign of life: when no key has
come for a while (``deadman_s``), the robot comes to stand on all feet and waits for the next key.
"""

import contextlib
import os
import re
import select
import sys
import termios
import tty
from dataclasses import replace
from types import TracebackType
from typing import Self, TextIO

from model.errors import BigantError
from model.values.faults import StopReason
from model.values.tick import Intent, Request, Tick
from robot.control.modes import GaitBook
from robot.run.operator import Interrupts

FREQUENCY_STEP_HZ = 0.01
STEER_STEP = 0.1
HELP = (
    "g walk  h stand  w/s faster/slower  a/d left/right  c straight  {gaits}"
    "q stop and quit  x EMERGENCY: cut torque"
)
ESC = "\x1b"
# Arrow keys, in the usual and in the application cursor mode of terminals.
ARROWS = {
    f"{ESC}{mode}{letter}": key
    for mode in "[O"
    for letter, key in (("A", "w"), ("B", "s"), ("D", "a"), ("C", "d"))
}
# A whole escape sequence (ECMA-48: CSI, SS3, or a character with Alt), and the beginning of one. Function
# keys of the Linux console begin with two brackets, so two brackets alone are not whole.
SEQUENCE = re.compile(
    r"\x1b(?:\[\[[0-?]*[ -/]*[@-~]|\[(?!\[)[0-?]*[ -/]*[@-~]|O[0-?]*[@-~]|[^\[O\x1b])"
)
BEGUN = re.compile(r"\x1b(?:\[\[?[0-?]*[ -/]*|O[0-?]*)?$")
PASTE_BEGINS, PASTE_ENDS = f"{ESC}[200~", f"{ESC}[201~"
BRACKETED_PASTE = "\x1b[?2004"  # h: the terminal marks what is pasted; l: it does not
MOST_KEYS = 16  # at once from fingers; more is a paste in a terminal that does not mark it
GAIT_KEYS = "123456789"


class Keys:
    """Single key presses from a terminal, without waiting; the terminal is put back on exit.

    Args:
        stream: The terminal to read from, standard input by default.

    Raises:
        BigantError: The stream is no terminal.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        source = stream if stream is not None else sys.stdin
        if not source.isatty():
            raise BigantError("--teleop needs a terminal to read keys from; run it in one")
        self._fd = source.fileno()
        self._before = termios.tcgetattr(self._fd)
        self._parser = KeyParser()
        self.ended = False

    def __enter__(self) -> Self:
        tty.setcbreak(self._fd)  # Ctrl-C still is an interrupt
        self._ask_terminal(f"{BRACKETED_PASTE}h")
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self._ask_terminal(f"{BRACKETED_PASTE}l")
        with contextlib.suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(self._fd, termios.TCSADRAIN, self._before)

    def read(self) -> list[str]:
        """Return the keys pressed since the last call; arrows come as w, s, a, d.

        What is no key of ours does nothing: other escape sequences, keys with Alt, pasted text.
        """
        text = ""
        while not self.ended and select.select([self._fd], [], [], 0)[0]:
            try:
                chunk = os.read(self._fd, 64)
            except OSError:  # the terminal is gone
                chunk = b""
            if not chunk:
                self.ended = True
            text += chunk.decode("ascii", errors="ignore")
        return self._parser.keys(text)

    def _ask_terminal(self, text: str) -> None:
        with contextlib.suppress(OSError):  # read-only, or gone
            os.write(self._fd, text.encode("ascii"))


class KeyParser:
    """Keys from what a terminal sends, which may come in pieces."""

    def __init__(self) -> None:
        self._begun = ""
        self._pasting = False

    def keys(self, text: str) -> list[str]:
        """Return the keys in a piece of text; what it leaves unfinished is kept for the next."""
        if self._begun == ESC and text and text[0] not in f"[O{ESC}":
            self._begun = ""  # the key Esc by itself; with Alt, both would have come at once
        text, self._begun = self._begun + text, ""
        keys: list[str] = []
        while text:
            if text[0] != ESC:
                keys += [] if self._pasting else [text[0]]
                text = text[1:]
            elif (sequence := SEQUENCE.match(text)) is not None:
                whole = sequence.group()
                self._pasting = (self._pasting or whole == PASTE_BEGINS) and whole != PASTE_ENDS
                keys += [ARROWS[whole]] if whole in ARROWS and not self._pasting else []
                text = text[len(whole) :]
            elif BEGUN.match(text):
                self._begun, text = text, ""
            else:
                text = text[1:]
        return keys if len(keys) <= MOST_KEYS else []


def gaits_by_key(book: GaitBook) -> dict[str, str]:
    """Return the gaits that have a key: the first nine, in the order of the robot file."""
    return dict(zip(GAIT_KEYS, book.gaits, strict=False))


def help_line(book: GaitBook) -> str:
    """Return what the keys do."""
    return HELP.format(gaits="".join(f"{key} {name}  " for key, name in gaits_by_key(book).items()))


def press(wish: Request, key: str, book: GaitBook) -> Request:
    """Return the wish after one key. A key that means nothing changes nothing.

    Args:
        wish: The wish before.
        key: One character.
        book: The gaits and the frequency that the servos allow for each; a press never asks for more.
    """
    match key.lower():
        case "g":
            return replace(wish, intent=Intent.WALK)
        case "h" | " ":
            return replace(wish, intent=Intent.STAND)
        case "w" | "s":
            step = FREQUENCY_STEP_HZ if key.lower() == "w" else -FREQUENCY_STEP_HZ
            return _retuned(wish, wish.frequency_hz + step, book)
        case "a" | "d":
            step = STEER_STEP if key.lower() == "a" else -STEER_STEP
            return replace(wish, steer=round(min(1.0, max(-1.0, wish.steer + step)), 3))
        case "c":
            return replace(wish, steer=0.0)
        case digit if digit in (gaits := gaits_by_key(book)):
            return _retuned(replace(wish, gait=gaits[digit]), wish.frequency_hz, book)
        case "q":
            return _stop(wish)
        case "x":
            return replace(wish, intent=Intent.CUT, reason=StopReason.EMERGENCY)
        case _:
            return wish


def _stop(wish: Request) -> Request:
    return replace(wish, intent=Intent.STOP, reason=StopReason.OPERATOR)


def _retuned(wish: Request, frequency_hz: float, book: GaitBook) -> Request:
    highest = book.frequency_limits[wish.gait]
    bounded = min(highest, max(FREQUENCY_STEP_HZ, frequency_hz))
    return replace(wish, frequency_hz=bounded)


class KeyboardOperator:
    """Turns key presses into requests.

    Args:
        keys: Where presses come from.
        start: The wish to begin with.
        book: The gaits and their limits.
        interrupts: Ctrl-C.
        deadman_s: Seconds without a key after which a walking robot stands.
    """

    def __init__(
        self, keys: Keys, start: Request, book: GaitBook, interrupts: Interrupts, deadman_s: float
    ) -> None:
        self._keys = keys
        self._wish = start
        self._book = book
        self._interrupts = interrupts
        self._deadman_ns = round(deadman_s * 1e9)
        self._last_key_ns: int | None = None

    @property
    def wish(self) -> Request:
        """The wish as it stands."""
        return self._wish

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        """Return the wish for the tick at ``t_ns``."""
        for key in self._keys.read():
            self._last_key_ns = t_ns
            if self._wish.intent not in {Intent.STOP, Intent.CUT} or key.lower() == "x":
                self._wish = press(self._wish, key, self._book)
        if self._keys.ended and self._wish.intent is not Intent.CUT:
            self._wish = _stop(self._wish)
        quiet_ns = t_ns - (self._last_key_ns if self._last_key_ns is not None else t_ns)
        if self._wish.intent is Intent.WALK and quiet_ns > self._deadman_ns:
            self._wish = replace(self._wish, intent=Intent.STAND)
        return self._interrupts.override(self._wish)
