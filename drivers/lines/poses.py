"""Absolute poses over UDP: motion capture, a camera, anything that can print a line.

A datagram holds one or more lines of text, UTF-8::

    t_unix_s x y z qx qy qz qw [sd_position [sd_angle]]

in s, m, rad; the quaternion turns body axes into the world's, scalar last. ``nan nan nan nan`` for it says
that only the place is known. Lines that begin with ``#`` are for people. The port is heard on this machine
only, unless another address is asked for; a sender elsewhere has to share our UNIX time (NTP, PTP).
"""

from math import isfinite, nan

import numpy as np

from drivers.clock import Clock
from drivers.lines.receiver import LineReceiver, stamp_ns
from drivers.lines.sources import LOOPBACK, UdpLines
from model.values.arrays import readonly
from model.values.faults import Fault, FaultKind
from model.values.readings import PoseRecord

MOST_LINES = 16  # in one read
UNIT_TOLERANCE = 0.01  # of a quaternion's length
SHORT, LONG = 8, 10


def parse_pose(line: str, offset_ns: int) -> PoseRecord:
    """Read one line.

    Args:
        line: The line.
        offset_ns: UNIX time less the loop's clock.

    Raises:
        ValueError: It makes no sense; says why.
    """
    words = line.split()
    if not SHORT <= len(words) <= LONG:
        raise ValueError(f"{len(words)} numbers in place of {SHORT} to {LONG}")
    numbers = [float(word) for word in words]
    if not all(isfinite(number) for number in numbers[:4]):
        raise ValueError("time and place must be finite")
    quaternion = np.array(numbers[4:SHORT])
    length = float(np.sqrt(quaternion @ quaternion))
    blind = bool(np.isnan(quaternion).all())
    if not blind and not abs(length - 1) < UNIT_TOLERANCE:
        raise ValueError(f"the quaternion has length {length:.3g}, not 1")
    sds = [*numbers[SHORT:], nan, nan][:2]
    if any(sd <= 0 for sd in sds):  # NaN is not told
        raise ValueError("a standard deviation must be above 0")
    return PoseRecord(
        t_ns=stamp_ns(words[0], offset_ns),
        position_W=readonly(np.array(numbers[1:4])),
        quaternion_xyzw=readonly(quaternion if blind else quaternion / length),
        sd_position_m=sds[0],
        sd_angle_rad=sds[1],
    )


class PoseListener:
    """Receives poses on a UDP port; never waits.

    Args:
        port: Port; 0 takes a free one, see ``port``.
        clock: The loop's clock.
        unix_ns: UNIX time at this moment.
        address: Where to listen; loopback unless another is asked for.

    Raises:
        ConfigError: The port cannot be had.
    """

    def __init__(self, port: int, clock: Clock, unix_ns: int, address: str = LOOPBACK) -> None:
        offset_ns = unix_ns - clock.now_ns()
        self._source = UdpLines(port, "--pose-udp", address)
        self._lines = LineReceiver(
            self._source,
            lambda line: parse_pose(line, offset_ns),
            clock,
            kind=FaultKind.POSE_BAD,
            name="pose udp",
            most=MOST_LINES,
        )

    @property
    def port(self) -> int:
        """The port."""
        return self._source.port

    def read(self) -> tuple[tuple[PoseRecord, ...], tuple[Fault, ...]]:
        """Return what has come since the last read, and faults."""
        return self._lines.read()

    def close(self) -> None:
        """Give the port back."""
        self._lines.close()
