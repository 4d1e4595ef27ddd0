"""The virtual unit on real sockets of the loopback interface: data, console, discovery."""

import contextlib
import socket
from collections.abc import Sequence

from drivers.ati.discovery import DiscoveredUnit, answer, question
from sim_hw.ati.console import open_console
from sim_hw.ati.unit import WnetWire
from sim_hw.interfaces import ConsoleEnd

LOOPBACK = "127.0.0.1"
RECEIVE_BYTES = 2048
MAC = "00:23:a7:0c:3d:5e"


class WnetSockets:
    """Serves a virtual unit; see ``sim_hw.interfaces.Served``.

    Args:
        unit: The unit, or the wire to it.

    Attributes:
        udp_port: Port of commands and data; the system chooses all three.
        console_port: Port of the console.
        discovery_port: Port asked by discovery.
    """

    def __init__(self, unit: WnetWire) -> None:
        self._unit = unit
        self._data, self.udp_port = _bound(socket.SOCK_DGRAM)
        self._discovery, self.discovery_port = _bound(socket.SOCK_DGRAM)
        self._listener, self.console_port = _bound(socket.SOCK_STREAM)
        self._listener.listen(1)
        self._client: socket.socket | None = None
        self._console: ConsoleEnd | None = None
        self._receiver: tuple[str, int] | None = None

    def filenos(self) -> Sequence[int]:
        """File descriptors to watch."""
        sockets = [self._data, self._discovery]
        sockets.append(self._listener if self._client is None else self._client)
        return [s.fileno() for s in sockets]

    def next_due_ns(self) -> int | None:
        """When the next record or console text is due."""
        times = [self._unit.next_due_ns()]
        if self._console is not None:
            times.append(self._console.next_due_ns())
        return min((t for t in times if t is not None), default=None)

    def service(self, now_ns: int) -> None:
        """Take commands, console text and discovery questions; send the records due."""
        self._take_commands(now_ns)
        self._take_questions()
        self._take_console(now_ns)
        for _, record in self._unit.poll(now_ns):
            if self._receiver is not None:
                with contextlib.suppress(OSError):
                    self._data.sendto(record, self._receiver)

    def _take_commands(self, now_ns: int) -> None:
        while True:
            try:
                data, sender = self._data.recvfrom(RECEIVE_BYTES)
            except OSError:  # nothing more, or the echo of a receiver that went away
                return
            if self._unit.command(data, now_ns, int(sender[1])):
                self._receiver = sender
            if self._unit.unit.console_reset:
                self._unit.unit.console_reset = False
                self._hang_up()

    def _take_questions(self) -> None:
        with contextlib.suppress(OSError):
            data, sender = self._discovery.recvfrom(RECEIVE_BYTES)
            if data == question():
                me = DiscoveredUnit(LOOPBACK, MAC, self._unit.unit.assumed.application, "loopback")
                self._discovery.sendto(answer(me), sender)

    def _take_console(self, now_ns: int) -> None:
        if self._client is None:
            try:
                self._client, _ = self._listener.accept()
            except OSError:
                return
            self._client.setblocking(False)
            # pieces that the unit prints one by one must not be put together again
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._console = open_console(self._unit)
        client, console = self._client, self._console
        while console is not None:
            try:
                data = client.recv(RECEIVE_BYTES)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            if not data:
                self._hang_up()
                return
            console.give(data, now_ns)
        self._print(now_ns)

    def _print(self, now_ns: int) -> None:
        if self._client is not None and self._console is not None:
            with contextlib.suppress(OSError):
                self._client.sendall(self._console.take(now_ns))

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None
        self._console = None

    def close(self) -> None:
        """Close every socket."""
        self._hang_up()
        for each in (self._data, self._discovery, self._listener):
            each.close()


def _bound(kind: socket.SocketKind) -> tuple[socket.socket, int]:
    """Return a socket on a port that the system chooses, and the port."""
    made = socket.socket(socket.AF_INET, kind)
    made.bind((LOOPBACK, 0))
    made.setblocking(False)
    return made, int(made.getsockname()[1])
