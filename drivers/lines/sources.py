"""Where lines of text come from: a UDP port of this machine, or a serial port that may be pulled."""

import socket
from typing import Protocol

import serial

from drivers.clock import Clock
from model.errors import ConfigError

LOOPBACK = "127.0.0.1"
# In one read: a sender gone mad must hold neither the loop nor the estimator nor the log.
LARGEST = 4096
MOST_DATAGRAMS = 64
LONGEST_LINE = 512
REOPEN_NS = 1_000_000_000


class LineSource(Protocol):
    """Something that lines come from."""

    def receive(self) -> list[str]:
        """Return the whole lines since the last call, oldest first; never waits.

        Raises:
            OSError: Nothing can be read now; says why. It may be called again.
        """
        ...

    def close(self) -> None:
        """Give back what it holds."""
        ...


class UdpLines:
    """Lines in datagrams to a UDP port; each datagram holds one or more whole ones.

    Args:
        port: Port; 0 takes a free one, see ``port``.
        option: What asked for it, for the error.
        address: Where to listen; loopback unless another is asked for.

    Raises:
        ConfigError: The port cannot be had.
    """

    def __init__(self, port: int, option: str, address: str = LOOPBACK) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((address, port))
        except OSError as error:
            self._socket.close()
            raise ConfigError(
                option, f"port {port} cannot be had ({error.strerror}); choose another"
            ) from error
        self._socket.setblocking(False)

    @property
    def port(self) -> int:
        """The port."""
        port: int = self._socket.getsockname()[1]
        return port

    def receive(self) -> list[str]:
        """Return the lines since the last call, those of a flood in later ones."""
        lines: list[str] = []
        for _ in range(MOST_DATAGRAMS):
            try:
                data = self._socket.recv(LARGEST)
            except BlockingIOError:
                break
            lines += data.decode("utf-8", errors="replace").splitlines()
        return lines

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()


class SerialLines:
    """Lines from a serial port. A port that vanishes is opened again when it is back.

    What comes before the first end of a line is left out: nobody knows where that line began.

    Args:
        name: The port, for example /dev/ttyUSB1.
        baud_rate: Its baud rate.
        option: What asked for it, for the error.
        clock: By which it waits before it tries again.

    Raises:
        ConfigError: The port cannot be opened.
    """

    def __init__(self, name: str, baud_rate: int, option: str, clock: Clock) -> None:
        self._name, self._baud_rate, self._clock = name, baud_rate, clock
        self._port: serial.Serial | None = None
        self._part = b""
        self._whole = False  # whether what comes next begins a line
        self._again_ns = 0
        try:
            self._open()
        except (OSError, ValueError) as error:
            words = f"{name} cannot be opened ({error}); name the IMU's port, or unplug who uses it"
            raise ConfigError(option, words) from error

    def _open(self) -> None:
        self._port = serial.Serial(self._name, self._baud_rate, timeout=0, exclusive=True)
        self._port.reset_input_buffer()
        self._part, self._whole = b"", False

    def receive(self) -> list[str]:
        """Return the whole lines since the last call.

        Raises:
            OSError: The port is gone; it is tried again once a second.
        """
        if self._port is None:
            now_ns = self._clock.now_ns()
            if now_ns < self._again_ns:
                raise OSError(f"{self._name} is gone")
            self._again_ns = now_ns + REOPEN_NS
            self._open()
        assert self._port is not None
        try:
            data = self._port.read(LARGEST)
        except OSError:  # of which pyserial's own error is one
            self.close()
            self._again_ns = self._clock.now_ns() + REOPEN_NS
            raise
        *lines, self._part = (self._part + data).split(b"\n")
        if lines and not self._whole:
            del lines[0]
            self._whole = True
        if len(self._part) > LONGEST_LINE:  # no text, or another baud rate
            self._part, self._whole = b"", False
            raise OSError(
                f"{self._name}: no end of line in {LONGEST_LINE} bytes; check the baud rate"
            )
        return [line.decode("utf-8", errors="replace") for line in lines]

    def close(self) -> None:
        """Give the port back."""
        if self._port is not None:
            self._port.close()
            self._port = None
