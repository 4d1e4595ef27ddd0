"""The virtual servo bus behind a pseudo-terminal: any Dynamixel program can open it.

A pseudo-terminal has no wire time and no baud rate of its own; the bus adds the first, and the second
is read from the terminal's settings, so that a program at the wrong baud rate meets silence. A wire whose
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
from collections.abc import Sequence
from pathlib import Path

from model.errors import ConnectionLost
from sim_hw.interfaces import ServoWire

# struct termios2: four flag words, line discipline, 19 control characters, then both speeds
_TERMIOS2 = struct.Struct("4I20B2I")
_TCGETS2 = 0x802C542A
READ_CHUNK = 4096


class PtyServoBus:
    """Serves a virtual bus on a pseudo-terminal; see ``sim_hw.interfaces.Served``.

    Args:
        bus: The virtual bus.
        link: Where to keep a link to the device, so that its name outlives an unplugged cable.

    Attributes:
        device_name: What to open.
    """

    def __init__(self, bus: ServoWire, link: Path | None = None) -> None:
        self._bus = bus
        self._link = link
        self._master = self._slave = -1
        self._cable_out = False  # pulled by the wire, which will plug it in again
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
        self._bus.poll(now_ns)
        try:
            if self._master >= 0:
                while data := self._read():
                    self._bus.receive(data, now_ns, self.baud_rate())
            data = self._bus.replies(now_ns)
        except ConnectionLost:
            self.unplug()
            self._cable_out = True
            return
        if self._cable_out:
            self._cable_out = False
            self._plug_in()
        if data:
            with contextlib.suppress(BlockingIOError):  # a client that does not read loses it
                os.write(self._master, data)

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
