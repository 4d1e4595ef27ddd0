"""The virtual unit on real sockets of the loopback interface: data, console, discovery."""

import contextlib
import socket
from collections.abc import Sequence

from drivers.ati_discovery import APPLICATION, FoundUnit, answer, question
from sim_hw.ati import VirtualWnet
from sim_hw.ati_console import ConsoleSession

LOOPBACK = "127.0.0.1"
RECEIVE_BYTES = 2048
MAC = "00:23:a7:0c:3d:5e"


class WnetSockets:
    """Serves a virtual unit; see ``sim_hw.interfaces.Served``.

    Args:
        unit: The unit.
        udp_port: Port of commands and data, 0 to let the system choose.
        console_port: Port of the console, 0 to let the system choose.
        discovery_port: Port asked by discovery, 0 to let the system choose.
    """

    def __init__(
        self,
        unit: VirtualWnet,
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
        self._session: ConsoleSession | None = None
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
        """When the next record is due."""
        return self._unit.next_due_ns()

    def service(self, now_ns: int) -> None:
        """Take commands, console text and discovery questions; send the records due."""
        self._take_commands(now_ns)
        self._take_questions()
        self._take_console()
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
            if self._unit.handle_datagram(data, now_ns):
                self._receiver = sender
            if self._unit.console_reset:
                self._unit.console_reset = False
                self._hang_up()

    def _take_questions(self) -> None:
        with contextlib.suppress(OSError):
            data, sender = self._discovery.recvfrom(RECEIVE_BYTES)
            if data == question():
                me = FoundUnit(LOOPBACK, MAC, f"{APPLICATION} (virtual)", "loopback")
                self._discovery.sendto(answer(me), sender)

    def _take_console(self) -> None:
        if self._client is None:
            try:
                self._client, _ = self._listener.accept()
            except OSError:
                return
            self._client.setblocking(False)
            self._session = ConsoleSession(self._unit)
            self._print(self._session.greeting())
        client, session = self._client, self._session
        while session is not None and client is self._client:
            try:
                data = client.recv(RECEIVE_BYTES)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self._hang_up()
                return
            self._print(session.receive(data))

    def _print(self, text: bytes) -> None:
        if self._client is not None:
            with contextlib.suppress(OSError):
                self._client.sendall(text)

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = self._session = None

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
