"""The virtual unit on real sockets of the loopback interface: data, console, discovery."""

import contextlib
import socket
from collections.abc import Sequence

from drivers.ati.discovery import FoundUnit, answer, question
from sim_hw.ati.console import open_console
from sim_hw.ati.wire import WnetWire
from sim_hw.interfaces import ConsoleEnd

LOOPBACK = "127.0.0.1"
RECEIVE_BYTES = 2048
MAC = "00:23:a7:0c:3d:5e"


class WnetSockets:
    """Serves a virtual unit; see ``sim_hw.interfaces.Served``.

    Args:
        unit: The unit, or the wire to it.
        udp_port: Port of commands and data, 0 to let the system choose.
        console_port: Port of the console, 0 to let the system choose.
        discovery_port: Port asked by discovery, 0 to let the system choose.
    """

    def __init__(
        self,
        unit: WnetWire,
        udp_port: int = 0,
        console_port: int = 0,
        discovery_port: int = 0,
    ) -> None:
        self._unit = unit
        self._data = _bound(socket.SOCK_DGRAM, udp_port)
        self._discovery = _bound(socket.SOCK_DGRAM, discovery_port)
        self._listener = _bound(socket.SOCK_STREAM, console_port)
        self._listener.listen(1)
        self._client: socket.socket | None = None
        self._console: ConsoleEnd | None = None
        self._receiver: tuple[str, int] | None = None

    @property
    def udp_port(self) -> int:
        """Port of commands and data."""
        return int(self._data.getsockname()[1])

    @property
    def console_port(self) -> int:
        """Port of the console."""
        return int(self._listener.getsockname()[1])

    @property
    def discovery_port(self) -> int:
        """Port asked by discovery."""
        return int(self._discovery.getsockname()[1])

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
                me = FoundUnit(LOOPBACK, MAC, self._unit.unit.assumed.application, "loopback")
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


def _bound(kind: socket.SocketKind, port: int) -> socket.socket:
    made = socket.socket(socket.AF_INET, kind)
    if kind == socket.SOCK_STREAM:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    made.bind((LOOPBACK, port))
    made.setblocking(False)
    return made
