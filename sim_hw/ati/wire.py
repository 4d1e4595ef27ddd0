"""The force-torque unit as the host's end sees it: sound, or with the faults of a scenario."""

from typing import Protocol

from sim_hw.ati.unit import VirtualWnet
from sim_hw.interfaces import ConsoleEnd


class WnetWire(Protocol):
    """The force-torque unit as the host's end sees it: commands in, datagrams out, a console beside."""

    @property
    def unit(self) -> VirtualWnet:
        """The unit itself."""
        ...

    def command(self, data: bytes, t_ns: int, host_port: int) -> bool:
        """Take a command sent from a port; return whether that is where datagrams go from now on."""
        ...

    def poll(self, t_ns: int) -> list[tuple[int, bytes]]:
        """Return the datagrams that have arrived by a time: when each did, and its bytes."""
        ...

    def next_due_ns(self) -> int | None:
        """When the next datagram may be due, None if none is."""
        ...

    def wrap_console(self, end: ConsoleEnd) -> ConsoleEnd:
        """Return a console session as this wire carries it."""
        ...
