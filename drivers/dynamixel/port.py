"""Ports for the Dynamixel SDK that keep our time, sleep while they wait, and say what they did.

``ClockedPort`` gives the SDK's ``PortHandler`` a monotonic clock and an honest timeout; the virtual
bus builds on it as well. ``BusPort`` is the real serial port. What is replaced, and why: the SDK
waits 34 ms for a silent servo whatever the adapter, spins while it waits, takes wall-clock time
that may step, opens at 1 Mbaud before the baud rate asked for, and refuses 4.5 Mbaud.
"""

import contextlib
import errno
import os
import select
import termios
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import serial
from dynamixel_sdk import PortHandler

from drivers.clock import Clock
from model.errors import BusError, ConnectionLost

# A byte on the wire: start bit, eight data bits, stop bit.
BITS_PER_BYTE = 10
# An adapter hands over a short answer when its latency timer runs out. 16 ms is FTDI's default;
# where the timer cannot be read (a pseudo-terminal, another chip) this is what we allow for.
UNKNOWN_LATENCY_MS = 8.0
# On top of twice the latency: the servo's own work and ours.
SLACK_MS = 2.0
# A request is at most 0.1 s of wire time; a port that takes none of it for so long is broken.
WRITE_TIMEOUT_S = 0.2
# Where Linux shows the latency timer of a USB serial adapter.
USB_SERIAL_DEVICES = Path("/sys/bus/usb-serial/devices")

READ_CHUNK = 1024  # more than is ever read at once
T = TypeVar("T")
# Called with "tx" or "rx", the bytes, and the time [ns].
Tap = Callable[[str, bytes, int], None]


class ClockedPort(PortHandler):  # type: ignore[misc]  # the SDK is not typed
    """A port of the SDK under one of our clocks.

    Args:
        name: Port name.
        baud_rate: Baud rate.
        clock: Where time comes from.

    Attributes:
        latency_ms: How long the adapter may hold back an answer; part of every timeout.
        latency_timer_ms: The same as the system reports it, None if it does not.
        bytes_sent: Bytes written so far.
        bytes_received: Bytes read so far.
        tap: Called with what is written and with what each read gave, nothing included; or None.
    """

    def __init__(self, name: str, baud_rate: int, clock: Clock) -> None:
        super().__init__(name)
        self.is_open = False
        self.baudrate = baud_rate
        self.tx_time_per_byte = 1000.0 * BITS_PER_BYTE / baud_rate  # [ms]
        self.clock = clock
        self.latency_ms = UNKNOWN_LATENCY_MS
        self.latency_timer_ms: float | None = None
        self.bytes_sent = 0
        self.bytes_received = 0
        self.tap: Tap | None = None

    @property
    def name(self) -> str:
        """Port name."""
        return str(self.port_name)

    def getCurrentTime(self) -> float:  # noqa: N802 - the SDK's name
        """Return monotonic time [ms]."""
        return self.clock.now_ns() * 1e-6

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        """Start the wait for an answer of so many bytes."""
        wire_ms = self.tx_time_per_byte * packet_length
        self.setPacketTimeoutMillis(wire_ms + 2 * self.latency_ms + SLACK_MS)

    def getTimeSinceStart(self) -> float:  # noqa: N802
        """Return the time since the wait began [ms]."""
        return self.getCurrentTime() - float(self.packet_start_time)

    def remaining_ms(self) -> float:
        """Return how much of the wait is left [ms]."""
        since_ms = self.clock.now_ns() * 1e-6 - float(self.packet_start_time)
        return max(0.0, float(self.packet_timeout) - since_ms)

    def readAnswers(self, count: int, size: int) -> bytes:  # noqa: N802
        """Read until so many answers of so many bytes are there, time is over, or something else comes."""
        data = b""
        # a piece that is no number of such answers holds something else
        while len(data) < count * size and not len(data) % size and self.remaining_ms() > 0:
            data += self.readPort(READ_CHUNK)
        return data

    def setBaudRate(self, baudrate: int) -> bool:  # noqa: N802
        """Take another baud rate; nothing else than the time of a byte changes."""
        self.baudrate = baudrate
        self.tx_time_per_byte = 1000.0 * BITS_PER_BYTE / baudrate
        return True

    def closePort(self) -> None:  # noqa: N802
        """Close; never fails, because it is on the way out."""
        self.is_open = False
        self.is_using = False

    def note(self, direction: str, data: bytes) -> None:
        """Count bytes and hand them to the tap, if there is one."""
        if direction == "tx":
            self.bytes_sent += len(data)
        else:
            self.bytes_received += len(data)
        if self.tap is not None and (data or direction == "rx"):
            self.tap(direction, data, self.clock.now_ns())


class BusPort(ClockedPort):
    """A serial port (a U2D2, another adapter, a pseudo-terminal)."""

    def openPort(self) -> bool:  # noqa: N802
        """Open at the right baud rate at once, for us alone; nothing happens if it is open.

        Raises:
            BusError: It cannot be opened; says why and what to do.
        """
        if self.is_open:
            return True
        try:
            self.ser = serial.Serial(
                port=self.port_name,
                baudrate=self.baudrate,
                bytesize=serial.EIGHTBITS,
                timeout=0,
                write_timeout=WRITE_TIMEOUT_S,
                exclusive=True,  # the SDK would let two programs talk at once
            )
        except (OSError, ValueError, termios.error) as error:  # SerialException is an OSError
            raise BusError(_cannot_open(self.name, self.baudrate, error), port=self.name) from error
        self.is_open = True
        self.is_using = False
        with contextlib.suppress(OSError, ValueError, NotImplementedError):
            self.ser.set_low_latency_mode(True)  # a pseudo-terminal has no such thing
        self.latency_timer_ms = latency_timer_ms(self.name)
        if self.latency_timer_ms is not None:
            self.latency_ms = self.latency_timer_ms
        return True

    def setBaudRate(self, baudrate: int) -> bool:  # noqa: N802
        """Change the baud rate without closing; 4.5 Mbaud included."""
        if self.is_open:
            self._lost(lambda: setattr(self.ser, "baudrate", baudrate))
        return super().setBaudRate(baudrate)

    def closePort(self) -> None:  # noqa: N802
        """Close, and give the port back."""
        was_open = self.is_open
        super().closePort()
        if was_open:
            with contextlib.suppress(OSError, termios.error):
                self.ser.close()

    def getBytesAvailable(self) -> int:  # noqa: N802
        """Return how many bytes have been received and not read."""
        return self._lost(lambda: int(self.ser.in_waiting))

    def clearPort(self) -> None:  # noqa: N802
        """Drop what has been received and not read."""
        self._lost(lambda: self.ser.reset_input_buffer())

    def writePort(self, packet: bytes) -> int:  # noqa: N802
        """Send bytes."""
        data = bytes(packet)
        written = self._lost(lambda: self.ser.write(data) or 0)
        self.note("tx", data[:written])
        return written

    def readPort(self, length: int) -> bytes:  # noqa: N802
        """Return up to ``length`` bytes; waits in the kernel, at most as long as the timeout."""

        def wait_and_read() -> bytes:
            wait_s = self.remaining_ms() * 1e-3
            ready, _, _ = select.select([self.ser.fileno()], [], [], wait_s)
            return bytes(self.ser.read(length)) if ready else b""

        data = self._lost(wait_and_read)
        self.note("rx", data)
        return data

    def _lost(self, action: Callable[[], T]) -> T:
        """Run an action; what an unplugged port raises (three unrelated types) becomes one."""
        if not self.is_open:
            raise ConnectionLost(f"{self.name} is not open", port=self.name)
        try:
            return action()
        except (OSError, termios.error) as error:
            raise ConnectionLost(
                f"{self.name} is gone ({error}): was the cable pulled?", port=self.name
            ) from error


def latency_timer_ms(port_name: str) -> float | None:
    """Return the adapter's latency timer as the system reports it [ms]."""
    try:  # a port that is unplugged just now cannot be followed to its device
        device = Path(os.path.realpath(port_name)).name
        return float((USB_SERIAL_DEVICES / device / "latency_timer").read_text())
    except (OSError, ValueError):
        return None


def _cannot_open(name: str, baud_rate: int, error: Exception) -> str:
    code = getattr(error, "errno", None)
    text = str(error)
    if code == errno.ENOENT or "No such file" in text:
        return f"there is no port {name}; see what is plugged in with: bigant devices"
    if code == errno.EACCES or "Permission denied" in text:
        return f"no permission to open {name}; add yourself to the group dialout and log in again"
    if "exclusively lock" in text or code in {errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK}:
        return f"{name} is in use by another program; close it first"
    if isinstance(error, ValueError):
        return f"{name} does not take {baud_rate} baud; choose another baud_rate in the robot file"
    return f"{name} cannot be opened: {text}"
