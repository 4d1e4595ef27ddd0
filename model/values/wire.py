"""Bytes as they passed on a wire, with their time: below every driver, above every cable."""

import enum
from dataclasses import dataclass


class Wire(enum.Enum):
    """Which wire."""

    SERVO_BUS = 0  # Dynamixel protocol 2.0
    FORCE_DATAGRAMS = 1  # the force-torque unit's commands and records
    FORCE_CONSOLE = 2  # its text console


@dataclass(frozen=True, slots=True)
class WireBytes:
    """One piece of traffic, cut as the program wrote or read it.

    Attributes:
        t_ns: When it was written, or when it was there to be read.
        wire: Which wire.
        sent: True for what we sent, False for what we received.
        data: The bytes; none where a read waited in vain.
    """

    t_ns: int
    wire: Wire
    sent: bool
    data: bytes
