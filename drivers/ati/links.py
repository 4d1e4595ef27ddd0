"""The two ways to the force-torque unit: datagrams, and a text console over TCP."""

import contextlib
import select
import socket
from typing import Protocol

from drivers.clock import Clock
from model.errors import ForceStreamError

RECEIVE_BYTES = 2048


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
        """Return what has arrived."""
        arrived: list[tuple[int, bytes]] = []
        while True:
            try:
                arrived.append((self._clock.now_ns(), self._socket.recv(RECEIVE_BYTES)))
            except BlockingIOError:
                return arrived
            except OSError:  # "connection refused" by the port's host: nobody there at the moment
                return arrived

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


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
