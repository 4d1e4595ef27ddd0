"""The virtual IMU's lines of text to the host: in memory, or on a pseudo-terminal."""

import contextlib
import os
import pty
import tty
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivers.lines.imu import imu_line
from model.values.arrays import FloatArray
from model.values.readings import ImuRecord
from sim_hw.assumed import ImuAssumed
from sim_hw.clock import VirtualClock
from sim_hw.interfaces import HostedWorld
from sim_hw.twin.imu import VirtualImu

READ_CHUNK = 4096


@dataclass(frozen=True, slots=True, eq=False)
class ImuSetup:
    """What a virtual IMU is to be.

    Attributes:
        assumed: Its errors.
        seed: Of every chance in it.
        to_body: Turns a vector in its axes into the body's, (3, 3); None where they are the same.
    """

    assumed: ImuAssumed
    seed: int
    to_body: FloatArray | None


class PrintedImu:
    """Prints the readings of a virtual IMU, with what may be wrong on the way.

    Args:
        setup: The IMU, with lines lost or damaged, silence, values that no longer change.

    Attributes:
        imu: The IMU itself.
        offset_ns: UNIX time less the clock of its readings.
    """

    def __init__(self, setup: ImuSetup) -> None:
        self.imu = VirtualImu(setup.assumed, setup.seed, setup.to_body)
        self.offset_ns = 0
        self._assumed = setup.assumed
        self._random = np.random.default_rng([setup.seed, 0x4C])
        self._first_ns: int | None = None
        self._last: ImuRecord | None = None

    def printed(self, now_ns: int) -> list[bytes]:
        """Return the lines that have arrived since the last call, each with its end."""
        lines = []
        for reading in self.imu.arrived(now_ns):
            if self._first_ns is None:
                self._first_ns = reading.t_ns
            line = self._printed(reading, (reading.t_ns - self._first_ns) * 1e-9)
            if line:
                lines.append(line)
        return lines

    def _printed(self, reading: ImuRecord, since_s: float) -> bytes:
        assumed = self._assumed
        lost, damaged = self._random.random(2).tolist()
        if since_s >= assumed.stuck_after_s and self._last is not None:
            reading = replace(self._last, t_ns=reading.t_ns)
        self._last = reading
        silent_s = since_s - assumed.silent_after_s
        if lost < assumed.loss or 0 <= silent_s < assumed.silent_for_s:
            return b""
        line = bytearray(imu_line(reading, self.offset_ns).encode() + b"\n")
        if damaged < assumed.damage:
            line[int(self._random.integers(len(line)))] ^= 1 << int(self._random.integers(8))
        return bytes(line)


class MemoryImuLines:
    """``drivers.lines.sources.LineSource`` to a virtual IMU under a virtual clock.

    Args:
        printer: The IMU.
        world: The world that it is in.
        clock: The virtual clock that all of them live by.
    """

    def __init__(self, printer: PrintedImu, world: HostedWorld, clock: VirtualClock) -> None:
        self._printer, self._world, self._clock = printer, world, clock
        self._part = b""

    def receive(self) -> list[str]:
        """Return the lines that have arrived by now."""
        now_ns = self._clock.now_ns()
        self._world.advance_to(now_ns)
        *lines, self._part = (self._part + b"".join(self._printer.printed(now_ns))).split(b"\n")
        return [line.decode("utf-8", errors="replace") for line in lines]

    def close(self) -> None:
        """Nothing to give back."""


class PtyImu:
    """Serves a virtual IMU on a pseudo-terminal; see ``sim_hw.interfaces.Served``.

    Args:
        printer: The IMU.

    Attributes:
        device_name: What to open.
    """

    def __init__(self, printer: PrintedImu) -> None:
        self._printer = printer
        # our own end of the client's side stays open: without it a read fails while nobody is there
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.device_name = os.ttyname(self._slave)

    def filenos(self) -> Sequence[int]:
        """File descriptors to watch."""
        return [self._master]

    def next_due_ns(self) -> int | None:
        """When it next wants to print; None, as the host looks often enough."""
        return None

    def service(self, now_ns: int) -> None:
        """Throw away what a client writes, print what is due; a client that does not read loses it."""
        with contextlib.suppress(OSError):
            os.read(self._master, READ_CHUNK)
        for line in self._printer.printed(now_ns):
            with contextlib.suppress(BlockingIOError):
                os.write(self._master, line)

    def close(self) -> None:
        """Give back the descriptors."""
        for fd in (self._slave, self._master):
            os.close(fd)
