"""Absolute poses over UDP: motion capture, a camera, anything that can print a line.

A datagram holds one or more lines of text, UTF-8::

    t_unix_s x y z qx qy qz qw [sd_position [sd_angle]]

in s, m, rad; the quaternion turns body axes into the world's, scalar last. ``nan nan nan nan`` for it says
that only the place is known. Lines that begin with ``#`` are for people. The port is heard on this machine
only, unless another address is asked for; a sender elsewhere has to share our UNIX time (NTP, PTP).
"""

import socket
from decimal import Decimal
from math import isfinite, nan

import numpy as np

from drivers.clock import Clock
from model.errors import ConfigError
from model.values.arrays import readonly
from model.values.faults import Fault, FaultKind
from model.values.readings import PoseRecord

LOOPBACK = "127.0.0.1"
# In one read: a sender gone mad must hold neither the loop nor the estimator nor the log.
LARGEST = 4096
MOST_DATAGRAMS = 64
MOST_LINES = 16
# A pose that is older or newer than this is of no use; its stamp is in ms or ns, or a clock is wrong.
MOST_AWAY_S = 30.0
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
        # a float of seconds since 1970 is good to a quarter of a microsecond only
        t_ns=int(Decimal(words[0]) * 1_000_000_000) - offset_ns,
        position_W=readonly(np.array(numbers[1:4])),
        quaternion_xyzw=readonly(quaternion if blind else quaternion / length),
        sd_position_m=sds[0],
        sd_angle_rad=sds[1],
    )


class PoseListener:
    """Hears poses on a UDP port; never waits.

    Args:
        port: Port; 0 takes a free one, see ``port``.
        clock: The loop's clock.
        unix_ns: UNIX time at this moment.
        address: Where to listen; loopback unless another is asked for.

    Raises:
        ConfigError: The port cannot be had.
    """

    def __init__(self, port: int, clock: Clock, unix_ns: int, address: str = LOOPBACK) -> None:
        self._clock = clock
        self._offset_ns = unix_ns - clock.now_ns()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((address, port))
        except OSError as error:
            self._socket.close()
            raise ConfigError(
                "--pose-udp", f"port {port} cannot be had ({error.strerror}); choose another"
            ) from error
        self._socket.setblocking(False)

    @property
    def port(self) -> int:
        """The port."""
        port: int = self._socket.getsockname()[1]
        return port

    def read(self) -> tuple[tuple[PoseRecord, ...], tuple[Fault, ...]]:
        """Return what has come since the last read, and faults."""
        records: list[PoseRecord] = []
        faults: list[Fault] = []
        lines = 0
        for _ in range(MOST_DATAGRAMS):
            try:
                data = self._socket.recv(LARGEST)
            except BlockingIOError:
                break
            except OSError as error:
                faults.append(Fault(FaultKind.POSE_BAD, "pose udp", str(error)))
                break
            for line in data.decode("utf-8", errors="replace").splitlines():
                if not line.strip() or line.lstrip().startswith("#"):
                    continue
                if lines == MOST_LINES:
                    detail = f"more than {MOST_LINES} poses in one period; the rest is left out"
                    faults.append(Fault(FaultKind.POSE_BAD, "pose udp", detail))
                    break
                lines += 1
                try:
                    records.append(self._timely(parse_pose(line, self._offset_ns)))
                except (ValueError, ArithmeticError) as error:
                    faults.append(
                        Fault(
                            FaultKind.POSE_BAD, "pose udp", f"{line[:60]!r} makes no sense: {error}"
                        )
                    )
        return tuple(records), tuple(faults[:1])

    def _timely(self, record: PoseRecord) -> PoseRecord:
        away_s = (record.t_ns - self._clock.now_ns()) * 1e-9
        if abs(away_s) > MOST_AWAY_S:
            raise ValueError(
                f"its time is {away_s:.3g} s from now; it has to be UNIX time in seconds"
            )
        return record

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()
