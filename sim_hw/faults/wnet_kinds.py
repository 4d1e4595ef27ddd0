"""The faults of the force-torque unit, one frozen dataclass each."""

from dataclasses import dataclass
from typing import ClassVar

from sim_hw.faults.kinds import ChanceFault, Fault
from sim_hw.typed_table import among, needed, within


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketLoss(ChanceFault):
    """A datagram is lost in the air."""

    acts_on: ClassVar[str] = "force unit: each datagram"


@dataclass(frozen=True, slots=True, kw_only=True)
class DuplicatePacket(ChanceFault):
    """A datagram arrives twice."""

    acts_on: ClassVar[str] = "force unit: each datagram"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReorderedPacket(ChanceFault):
    """A datagram arrives behind the next one."""

    acts_on: ClassVar[str] = "force unit: each datagram"


@dataclass(frozen=True, slots=True, kw_only=True)
class Batching(Fault):
    """Several records come in one datagram. When the real unit does so is not known.

    Attributes:
        records: How many; ATI's receive buffer holds six records of six transducers.
    """

    acts_on: ClassVar[str] = "force unit: how records go into datagrams"
    records: int = within(3, 1, 24)


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskChange(Fault):
    """Transducers vanish from the records, as when they are switched off.

    Attributes:
        transducers: Their numbers, from 1.
    """

    acts_on: ClassVar[str] = "force unit: each record"
    transducers: tuple[int, ...] = needed(1, 6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation(Fault):
    """A transducer reports saturation: its bit is set and its LED is red.

    Attributes:
        transducer: Its number, from 1.
        counts: What all its axes then read; 2^31 - 1 is assumed.
    """

    acts_on: ClassVar[str] = "force unit: each record"
    transducer: int = needed(1, 6)
    counts: int = within(2**31 - 1, -(2**31), 2**31 - 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class LowBattery(Fault):
    """The battery runs low: there is no flag, only the LED and a byte of unknown scale.

    Attributes:
        level: The battery byte; assumed.
        led: The battery LED; red is assumed.
    """

    acts_on: ClassVar[str] = "force unit: each record"
    level: int = within(1, 0, 255)
    led: str = among("red", "orange", "off", "green")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockStep(Fault):
    """The unit's clock jumps, as when NTP finds its server, and jumps back at the end.

    Attributes:
        step_s: By so much.
    """

    acts_on: ClassVar[str] = "force unit: the stamp of each record"
    step_s: float = needed(-524_288.0, 524_288.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rollover(Fault):
    """The unit's stamps, which wrap every 12.1 days, wrap in this run.

    That is ``start_s`` after its first record, not after the scenario's beginning, because a clock does not
    know of that; before it the stamps count up to the wrap. It has no end, and only the first one counts.
    """

    acts_on: ClassVar[str] = "force unit: the stamp of each record"


@dataclass(frozen=True, slots=True, kw_only=True)
class PortChangeStall(Fault):
    """Asked to send to another host port than at power-up, the unit closes one and opens none.

    It stays silent until the fault ends, which stands for a power cycle.

    Attributes:
        stored_port: The port it was powered up with; 0 for that of the first start command.
    """

    acts_on: ClassVar[str] = "force unit: its data port"
    stored_port: int = within(0, 0, 65_535)


@dataclass(frozen=True, slots=True, kw_only=True)
class SilentStop(Fault):
    """The stream stops without a word.

    Attributes:
        needs_start: After the end it waits for a new start command (assumed), or else goes on by itself.
    """

    acts_on: ClassVar[str] = "force unit: its data port"
    needs_start: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleStall(Fault):
    """The console takes what it is told and prints nothing until the end."""

    acts_on: ClassVar[str] = "force unit: its console"


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitConsole(Fault):
    """The console prints in pieces.

    Attributes:
        piece_bytes: Length of a piece.
        gap_s: Time between two.
    """

    acts_on: ClassVar[str] = "force unit: its console"
    piece_bytes: int = within(7, 1, 1024)
    gap_s: float = within(0.001, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleRate(Fault):
    """The unit samples faster or slower than it was told; its stamps stay right (assumed).

    Attributes:
        percent: By so much.
    """

    acts_on: ClassVar[str] = "force unit: its sample clock"
    percent: float = needed(-50.0, 50.0)
