"""The virtual servo bus behind a pseudo-terminal: any Dynamixel program can open it.

A pseudo-terminal has no wire time and no baud rate of its own; the first is added, and the second is read
from the terminal's settings, so that a program at the wrong baud rate meets silence. A request counts as
received, at once, for the time at which its last byte would be on the wire; replies come at theirs, and one
that a busy computer hands over late is counted. A wire whose
adapter is unplugged takes the pseudo-terminal with it; plugged in again there is a new one, and a link, if
there is one, points to it.
"""

import contextlib
import errno
import fcntl
import os
import pty
import struct
import tty
from collections.abc import Callable, Sequence
from pathlib import Path

from drivers.dynamixel.units import BAUD_CODES
from model.errors import ConnectionLost
from sim_hw.dynamixel.bus import wire_ns
from sim_hw.interfaces import ServoWire

# struct termios2: four flag words, line discipline, 19 control characters, then both speeds
_TERMIOS2 = struct.Struct("4I20B2I")
_TCGETS2 = 0x802C542A
READ_CHUNK = 4096
LATE_NS = 20_000_000  # no servo is ever that late
NOTICE_PERIOD_NS = 10_000_000_000


class PtyServoBus:
    """Serves a virtual bus on a pseudo-terminal; see ``sim_hw.interfaces.Served``.

    Args:
        bus: The virtual bus.
        link: Where to keep a link to the device, so that its name outlives an unplugged cable.
        notice: Told in words, not too often, that answers were late.

    Attributes:
        device_name: What to open.
        late_answers: How often the host had to wait for longer than ``LATE_NS`` because we were late.
    """

    def __init__(
        self,
        bus: ServoWire,
        link: Path | None = None,
        notice: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._bus = bus
        self._notice = notice
        self._link = link
        self._master = self._slave = -1
        self._cable_out = False  # pulled by the wire, which will plug it in again
        self._wire_ns = 0  # until then the host's bytes are on the wire
        self._served_ns: int | None = None
        self.late_answers = 0
        self._latest_ns = 0  # the longest of them since the last notice
        self._notice_ns: int | None = None
        self._plug_in()

    def _plug_in(self) -> None:
        # our own end of the client's side stays open: without it a read fails while nobody is there
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.device_name = os.ttyname(self._slave)
        if self._link is not None:
            self._link.symlink_to(self.device_name)
            self.device_name = str(self._link)

    def filenos(self) -> Sequence[int]:
        """File descriptors to watch."""
        return [self._master] if self._master >= 0 else []

    def next_due_ns(self) -> int | None:
        """When the next reply is complete."""
        return self._bus.next_reply_ns()

    def baud_rate(self) -> int:
        """Return the baud rate that the client has set."""
        raw = fcntl.ioctl(self._master, _TCGETS2, bytes(_TERMIOS2.size))
        return int(_TERMIOS2.unpack(raw)[-1])

    def service(self, now_ns: int) -> None:
        """Take what has arrived, send what is due."""
        if self._master < 0 and not self._cable_out:
            return
        idle_ns = 0 if self._served_ns is None else now_ns - self._served_ns
        due_ns = self._bus.next_reply_ns()
        self._served_ns = now_ns
        self._wire_ns = max(now_ns, self._wire_ns)
        self._bus.poll(self._wire_ns)
        requests = False
        try:
            while self._master >= 0 and (data := self._read()):
                requests = True
                self._receive(data)
            data = self._bus.replies(self._wire_ns)
        except ConnectionLost:
            self.unplug()
            self._cable_out = True
            return
        if self._cable_out:
            self._cable_out = False
            self._plug_in()
        if data:
            self._count(now_ns - due_ns if due_ns is not None else 0, now_ns)
            with contextlib.suppress(BlockingIOError):  # a client that does not read loses it
                os.write(self._master, data)
        elif requests:
            self._count(idle_ns, now_ns)  # they may have waited for so long

    def _receive(self, data: bytes) -> None:
        rate = self.baud_rate()
        if rate in BAUD_CODES:  # nobody understands another one
            self._wire_ns += wire_ns(len(data), rate)
            self._bus.receive(data, self._wire_ns, rate)

    def _count(self, late_ns: int, now_ns: int) -> None:
        if late_ns <= LATE_NS:
            return
        self.late_answers += 1
        self._latest_ns = max(self._latest_ns, late_ns)
        if self._notice_ns is None or now_ns - self._notice_ns >= NOTICE_PERIOD_NS:
            self._notice_ns = now_ns
            self._notice(
                f"the virtual servos answer late, by up to {self._latest_ns * 1e-6:.0f} ms (times so "
                f"far: {self.late_answers}): this computer is too busy; real servos are never that late"
            )
            self._latest_ns = 0

    def _read(self) -> bytes:
        try:
            return os.read(self._master, READ_CHUNK)
        except OSError as error:
            if error.errno in {
                errno.EAGAIN,
                errno.EIO,
            }:  # nothing there, or nobody at the other end
                return b""
            raise

    def unplug(self) -> None:
        """Pull the cable: the device vanishes under the client."""
        for fd in (self._slave, self._master):
            if fd >= 0:
                os.close(fd)
        self._master = self._slave = -1
        if self._link is not None:
            self._link.unlink(missing_ok=True)

    def close(self) -> None:
        """Give back the descriptors."""
        self._cable_out = False
        self.unplug()
