"""The two links to the force-torque unit: datagrams, and a text console over TCP.

Linux stamps a datagram when it arrives, by ``CLOCK_REALTIME``; the stamp is taken over to the monotonic
clock when the datagram is read. Elsewhere, and where the stamp makes no sense (the time of day was set in
between), the time of reading counts.
"""

import contextlib
import select
import socket
import struct
import sys
import time
from collections.abc import Iterable
from typing import Protocol

from drivers.clock import Clock
from model.errors import ForceStreamError

RECEIVE_BYTES = 2048
# One call returns at most so many, half a second's at 250 Hz: a flood must not hold the loop up.
MOST_DATAGRAMS = 128
# A stamp older than this when it is read is no stamp: the loop reads every 10 ms.
OLDEST_NS = 2_000_000_000
# SO_TIMESTAMPNS and SCM_TIMESTAMPNS of Linux, which Python does not name; it gives a timespec.
TIMESTAMPNS = 35
_TIMESPEC = struct.Struct("@ll")


class DatagramLink(Protocol):
    """Datagrams to and from the unit."""

    def send(self, data: bytes) -> None:
        """Send one datagram; one that cannot be sent is lost."""
        ...

    def receive(self) -> list[tuple[int, bytes]]:
        """Return what has arrived, without waiting: host time [ns] and bytes, oldest first."""
        ...

    def close(self) -> None:
        """Give back what it holds."""
        ...


class TextLink(Protocol):
    """The unit's console."""

    def write(self, data: bytes) -> None:
        """Send bytes."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting at most so long for the first byte; empty if none."""
        ...

    def close(self) -> None:
        """Hang up."""
        ...


class UdpLink:
    """Datagrams over UDP from one fixed local port.

    Args:
        address: The unit.
        port: Its port.
        local_port: Ours; 0 lets the system choose.
        clock: Clock that stamps what arrives.

    Raises:
        ForceStreamError: The local port is taken, or the address is not known.
    """

    def __init__(self, address: str, port: int, local_port: int, clock: Clock) -> None:
        self._clock = clock
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        if sys.platform == "linux":
            with contextlib.suppress(OSError):
                self._socket.setsockopt(socket.SOL_SOCKET, TIMESTAMPNS, 1)
        try:
            self._socket.bind(("", local_port))
            self._socket.connect((address, port))
        except OSError as error:
            self._socket.close()
            unknown = isinstance(error, socket.gaierror)
            hint = "is the address right?" if unknown else "is another program using the port?"
            raise ForceStreamError(
                f"no datagrams to {address}:{port} from local port {local_port}: "
                f"{error.strerror or error}; {hint}"
            ) from error

    def send(self, data: bytes) -> None:
        """Send one datagram."""
        with contextlib.suppress(OSError):
            self._socket.send(data)

    def receive(self) -> list[tuple[int, bytes]]:
        """Return what has arrived, at most ``MOST_DATAGRAMS``; the rest comes with the next call."""
        arrived: list[tuple[int, bytes]] = []
        unix_less_ours_ns: int | None = None
        for _ in range(MOST_DATAGRAMS):
            try:
                data, notes, _, _ = self._socket.recvmsg(RECEIVE_BYTES, _NOTE_BYTES)
            except BlockingIOError:
                break
            except OSError:  # "connection refused" by the port's host: nobody there at the moment
                break
            now_ns = self._clock.now_ns()
            if unix_less_ours_ns is None:
                unix_less_ours_ns = self._unix_less_ours_ns()
            arrived.append((arrival_ns(_stamp_ns(notes), now_ns, unix_less_ours_ns), data))
        return arrived

    def _unix_less_ours_ns(self) -> int:
        """Compare the time of day with our clock, the best of three: another program may come between."""
        pairs = []
        for _ in range(3):
            before_ns, unix_ns, after_ns = (
                self._clock.now_ns(),
                time.time_ns(),
                self._clock.now_ns(),
            )
            pairs.append((after_ns - before_ns, unix_ns - (before_ns + after_ns) // 2))
        return min(pairs)[1]

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


_NOTE_BYTES = socket.CMSG_SPACE(_TIMESPEC.size)


def _stamp_ns(notes: Iterable[tuple[int, int, bytes]]) -> int | None:
    """Return the time of day at which the kernel received a datagram, None if it does not say so."""
    for level, kind, data in notes:
        if (level, kind, len(data)) == (socket.SOL_SOCKET, TIMESTAMPNS, _TIMESPEC.size):
            seconds, nanoseconds = _TIMESPEC.unpack(data)
            return int(seconds) * 1_000_000_000 + int(nanoseconds)
    return None


def arrival_ns(stamp_ns: int | None, now_ns: int, unix_less_ours_ns: int) -> int:
    """Return when a datagram arrived by our clock.

    Args:
        stamp_ns: Time of day of its arrival, None if it is not known.
        now_ns: Time by our clock at which it was read.
        unix_less_ours_ns: Time of day less our time.
    """
    if stamp_ns is None:
        return now_ns
    waited_ns = now_ns - (stamp_ns - unix_less_ours_ns)
    return now_ns - waited_ns if 0 <= waited_ns <= OLDEST_NS else now_ns


class TcpTextLink:
    """The console over TCP.

    Args:
        address: The unit.
        port: Its console port.
        timeout_s: Longest wait for the connection.

    Raises:
        ForceStreamError: Nobody answers.
    """

    def __init__(self, address: str, port: int, timeout_s: float = 5.0) -> None:
        try:
            self._socket = socket.create_connection((address, port), timeout=timeout_s)
        except OSError as error:
            raise ForceStreamError(
                f"no force-torque unit answers at {address}, port {port} "
                f"({error.strerror or error}): check its power and network, or run with "
                "--force-unit none"
            ) from error
        self._socket.settimeout(timeout_s)

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            ForceStreamError: The unit has hung up.
        """
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise ForceStreamError(f"the force-torque unit's console hung up: {error}") from error

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived.

        Raises:
            ForceStreamError: The unit has hung up.
        """
        ready, _, _ = select.select([self._socket], [], [], timeout_s)
        if not ready:
            return b""
        try:
            data = self._socket.recv(RECEIVE_BYTES)
        except OSError as error:
            raise ForceStreamError(f"the force-torque unit's console hung up: {error}") from error
        if not data:
            raise ForceStreamError("the force-torque unit closed its console: is it in use?")
        return data

    def close(self) -> None:
        """Hang up."""
        with contextlib.suppress(OSError):
            self._socket.close()
