"""Talking to the force-torque unit's console: one command, one answer.

The unit echoes the command, prints lines and then a prompt ``>`` at the start of a line. Late bytes of
an earlier answer may come first, a banner at connect, and telnet option bytes at any time. So: look for
the echo of the command, then read until the prompt, with a deadline, and skip the rest.
"""

import re

from drivers.ati.links import TextLink
from drivers.clock import Clock
from model.errors import ForceStreamError

ANSWER_LIMIT_S = 3.0
DRAIN_S = 0.05
PROMPT = re.compile(rb"(?:^|[\r\n])>\s*$")
# Commands that would write a calibration or firmware, or print the Wi-Fi key: not from here.
FORBIDDEN = re.compile(
    r"^\s*(CAL\s+(MATRIX|MAX|DATE|SERIAL|PART|FORCE|TORQUE)|TEST|EEPOT|FDEL|FHEX|FCLOSE|NET\s+KEY"
    r"|[GO]\s+\d)",
    re.IGNORECASE,
)
_IAC = re.compile(rb"\xff(?:[\xfb-\xfe].|\xfa.*?\xff\xf0|.)", re.DOTALL)


class Console:
    """A console session.

    Args:
        link: The connection.
        clock: Clock for deadlines.
    """

    def __init__(self, link: TextLink, clock: Clock) -> None:
        self._link = link
        self._clock = clock

    def query(self, command: str) -> str:
        """Send a command and return its answer, without echo and prompt.

        Raises:
            ForceStreamError: No answer in time, or the command may not be sent from here.
        """
        if FORBIDDEN.match(command):
            raise ForceStreamError(f"{command.split()[0]} writes to the sensor; not sent")
        deadline_ns = self._clock.now_ns() + round(ANSWER_LIMIT_S * 1e9)
        chatters = self._wake(deadline_ns)
        self._link.write(command.encode("ascii") + b"\r\n")
        received = b""
        while True:
            answer = _answer(received, command)
            if answer is not None:
                return answer
            left_s = (deadline_ns - self._clock.now_ns()) * 1e-9
            if left_s <= 0:
                raise ForceStreamError(
                    f"the force-torque unit did not answer {command!r} in {ANSWER_LIMIT_S:g} s: "
                    "switch it off and on"
                    + "; its console prints all the time (DUMP or NET DEBUG is on)"
                    * chatters
                )
            received += self._link.read(left_s)

    def _wake(self, deadline_ns: int) -> bool:
        """An empty line first, as ATI's own program does; whatever it brings is dropped.

        Returns:
            Whether it never stopped bringing something; half the time is left for the answer then.
        """
        self._link.write(b"\r\n")
        until_ns = (self._clock.now_ns() + deadline_ns) // 2
        while self._link.read(DRAIN_S):
            if self._clock.now_ns() >= until_ns:
                return True
        return False

    def close(self) -> None:
        """Hang up."""
        self._link.close()


def _answer(received: bytes, command: str) -> str | None:
    """Return the answer in what has been received, None while it is not complete."""
    plain = _IAC.sub(b"", received)
    echo = re.search(rb"(?i)(?:^|[\r\n>])" + re.escape(command.encode("ascii")) + rb"\r?\n", plain)
    if echo is None:
        return None
    rest = plain[echo.end() - 1 :]
    prompt = PROMPT.search(rest)
    if prompt is None:
        return None
    return rest[: prompt.start()].decode("ascii", errors="replace").strip("\r\n")
