"""The virtual servo bus behind a pseudo-terminal: any Dynamixel program can open it.

A pseudo-terminal has no wire time and no baud rate of its own; the bus adds the first, and the second
is read from the terminal's settings, so that a program at the wrong baud rate meets silence.
"""

import contextlib
import errno
import fcntl
import os
import pty
import struct
import tty
from collections.abc import Sequence

from sim_hw.servos import VirtualServoBus

# struct termios2: four flag words, line discipline, 19 control characters, then both speeds
_TERMIOS2 = struct.Struct("4I20B2I")
_TCGETS2 = 0x802C542A
READ_CHUNK = 4096


class PtyServoBus:
    """Serves a virtual bus on a pseudo-terminal; see ``sim_hw.interfaces.Served``.

    Args:
        bus: The virtual bus.
    """

    def __init__(self, bus: VirtualServoBus) -> None:
        self._bus = bus
        # our own end of the client's side stays open: without it a read fails while nobody is there
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.device_name = os.ttyname(self._slave)

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
        if self._master < 0:
            return
        self._bus.poll(now_ns)
        while data := self._read():
            self._bus.receive(data, now_ns, self.baud_rate())
        data = self._bus.replies(now_ns)
        if data:
            with contextlib.suppress(BlockingIOError):  # a client that does not read loses it
                os.write(self._master, data)

    def _read(self) -> bytes:
        try:
            return os.read(self._master, READ_CHUNK)
        except BlockingIOError:
            return b""
        except OSError as error:
            if error.errno == errno.EIO:
                return b""
            raise

    def unplug(self) -> None:
        """Pull the cable: the device vanishes under the client."""
        for fd in (self._slave, self._master):
            if fd >= 0:
                os.close(fd)
        self._master = self._slave = -1

    def close(self) -> None:
        """Give back the descriptors."""
        self.unplug()
