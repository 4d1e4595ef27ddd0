"""Ground truth from the device process to whoever wants to compare with it.

It stands where a motion-capture system stands on the real robot: beside the robot, on a path of its
own, never through the robot's devices.
"""

import contextlib
import socket
import struct

import numpy as np

from model.values.arrays import readonly
from model.values.readings import BodyTruth

_HEAD = struct.Struct("<qI")


def pack_truth(truth: BodyTruth) -> bytes:
    """Return one truth as bytes: time, number of legs, then float64 values in field order."""
    legs = len(truth.contact)
    values = np.concatenate(
        [
            truth.position_W,
            truth.quaternion_xyzw,
            truth.velocity_B,
            truth.angular_velocity_B,
            truth.foot_position_W.ravel(),
            truth.foot_velocity_W.ravel(),
            truth.foot_force_B.ravel(),
            truth.contact.astype(np.float64),
        ]
    )
    return _HEAD.pack(truth.t_ns, legs) + values.tobytes()


def unpack_truth(data: bytes) -> BodyTruth:
    """Inverse of ``pack_truth``."""
    t_ns, legs = _HEAD.unpack_from(data)
    values = np.frombuffer(data, dtype=np.float64, offset=_HEAD.size)
    at = np.cumsum([3, 4, 3, 3, 3 * legs, 3 * legs, 3 * legs])
    part = [readonly(p) for p in np.split(values, at)]
    return BodyTruth(
        t_ns=t_ns,
        position_W=part[0],
        quaternion_xyzw=part[1],
        velocity_B=part[2],
        angular_velocity_B=part[3],
        foot_position_W=part[4].reshape(legs, 3),
        foot_velocity_W=part[5].reshape(legs, 3),
        foot_force_B=part[6].reshape(legs, 3),
        contact=readonly(part[7] > 0.5),
    )


class TruthSender:
    """Sends truth without ever blocking the plant; a receiver that is not there loses it."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._end.setblocking(False)

    def send(self, truth: BodyTruth) -> None:
        """Send one truth, or drop it if the receiver does not keep up or is gone."""
        with contextlib.suppress(OSError):
            self._end.send(pack_truth(truth))


class TruthReceiver:
    """Keeps the newest truth received."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._end.setblocking(False)
        self._latest: BodyTruth | None = None

    def latest(self) -> BodyTruth | None:
        """Return the newest truth, None if none ever came."""
        newest: bytes | None = None
        while True:
            try:
                newest = self._end.recv(65536) or newest
            except (BlockingIOError, ConnectionError):
                break
        if newest is not None:
            self._latest = unpack_truth(newest)
        return self._latest

    def close(self) -> None:
        """Give back the socket."""
        self._end.close()
