"""The faults a scenario can hold, one frozen dataclass each. Times are seconds after it begins.

``rate`` is the probability that one reply or datagram is hit while the fault is on, drawn from the
scenario's seed; ``count`` ends the fault after so many hits, 0 for never.
"""

import math
from dataclasses import dataclass
from types import MappingProxyType

from sim_hw.scenario_table import among, needed, within

LONGEST_S = math.inf
STALL_CURRENT_A = 5.2  # data sheet, at 12 V


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """When a fault is on.

    Attributes:
        start_s: From then on.
        duration_s: For so long; endless if not given.
    """

    start_s: float = within(0.0, 0.0, LONGEST_S)
    duration_s: float = within(math.inf, 0.0, LONGEST_S)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChanceFault(Fault):
    """A fault that hits single replies or datagrams.

    Attributes:
        rate: Probability of each to be hit.
        count: Hits after which it is over, 0 for no end.
    """

    rate: float = within(1.0, 0.0, 1.0)
    count: int = within(0, 0, 1_000_000_000)


# Servo bus: bytes.


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplyFault(ChanceFault):
    """A fault of servo replies.

    Attributes:
        servo: Id whose replies are hit; all if not given.
    """

    servo: int | None = within(None, 0, 252)


@dataclass(frozen=True, slots=True, kw_only=True)
class LostReply(ReplyFault):
    """The reply never arrives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BitFlip(ReplyFault):
    """One bit of the reply arrives inverted.

    Attributes:
        bit: Which, counted from the lowest bit of the first byte; -1 draws one for each reply.
    """

    bit: int = within(-1, -1, 32_767)


@dataclass(frozen=True, slots=True, kw_only=True)
class LateReply(ReplyFault):
    """The reply arrives late; others do not wait for it.

    Attributes:
        delay_s: By so much.
    """

    delay_s: float = within(0.03, 0.0, 10.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TruncatedReply(ReplyFault):
    """Only the beginning of the reply arrives.

    Attributes:
        keep_bytes: So many bytes of it; -1 for half.
    """

    keep_bytes: int = within(-1, -1, 4096)


@dataclass(frozen=True, slots=True, kw_only=True)
class DuplicatedReply(ReplyFault):
    """The reply arrives twice in a row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignReply(ReplyFault):
    """A status of another id, that nobody asked, comes before the reply.

    Attributes:
        foreign_id: That id.
    """

    foreign_id: int = within(99, 0, 252)


@dataclass(frozen=True, slots=True, kw_only=True)
class Echo(ChanceFault):
    """The host hears its own request, as with an adapter that does not switch its receiver off."""


# Servo bus: things.


@dataclass(frozen=True, slots=True, kw_only=True)
class SilentServo(Fault):
    """A servo neither hears nor speaks; its motor goes on as it was told last.

    Attributes:
        servo: Its id.
        chain_breaks: In a sync or bulk read, those behind it wait for it and stay silent as well. Both
            were reported of MX servos, so it is a choice.
    """

    servo: int = needed(0, 252)
    chain_breaks: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Brownout(Fault):
    """The servo's supply fails: RAM and turns are lost, and it is gone until the power is back.

    Attributes:
        servo: Its id; all if not given.
    """

    servo: int | None = within(None, 0, 252)


@dataclass(frozen=True, slots=True, kw_only=True)
class Overheating(Fault):
    """The motor is as hot as said, whatever it does.

    Attributes:
        servo: Its id.
        temperature_c: Temperature.
    """

    servo: int = needed(0, 252)
    temperature_c: float = within(85.0, -20.0, 200.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Overload(Fault):
    """The motor's current is measured as said while torque is on; the servo judges it by its own rule.

    Attributes:
        servo: Its id.
        current_a: Current.
    """

    servo: int = needed(0, 252)
    current_a: float = within(STALL_CURRENT_A, -20.0, 20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class StuckShaft(Fault):
    """The shaft is jammed in the plant: dry friction that no servo overcomes.

    Attributes:
        servo: Id of the servo that drives it.
        torque_n_m: The friction.
    """

    servo: int = needed(0, 252)
    torque_n_m: float = within(50.0, 0.0, 1e3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Unplug(Fault):
    """The USB cable is pulled; at the end it is plugged in again."""


# Force-torque unit.


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketLoss(ChanceFault):
    """A datagram is lost in the air."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DuplicatePacket(ChanceFault):
    """A datagram arrives twice."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReorderedPacket(ChanceFault):
    """A datagram arrives behind the next one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Batching(Fault):
    """Several records come in one datagram. When the real unit does so is not known.

    Attributes:
        records: How many; ATI's receive buffer holds six records of six transducers.
    """

    records: int = within(3, 1, 24)


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskChange(Fault):
    """Transducers vanish from the records, as when they are switched off.

    Attributes:
        transducers: Their numbers, from 1.
    """

    transducers: tuple[int, ...] = needed(1, 6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation(Fault):
    """A transducer reports saturation: its bit is set and its LED is red.

    Attributes:
        transducer: Its number, from 1.
        counts: What all its axes then read; 2^31 - 1 is assumed.
    """

    transducer: int = needed(1, 6)
    counts: int = within(2**31 - 1, -(2**31), 2**31 - 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class LowBattery(Fault):
    """The battery runs low: there is no flag, only the LED and a byte of unknown scale.

    Attributes:
        level: The battery byte; assumed.
        led: The battery LED; red is assumed.
    """

    level: int = within(1, 0, 255)
    led: str = among("red", "orange", "off", "green")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockStep(Fault):
    """The unit's clock jumps, as when NTP finds its server, and jumps back at the end.

    Attributes:
        step_s: By so much.
    """

    step_s: float = needed(-524_288.0, 524_288.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rollover(Fault):
    """The unit's stamps, which wrap every 12.1 days, wrap in this run.

    That is ``start_s`` after its first record, not after the scenario's beginning, because a clock does not
    know of that; before it the stamps count up to the wrap. It has no end, and only the first one counts.
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class PortChangeStall(Fault):
    """Asked to send to another host port than at power-up, the unit closes one and opens none.

    It stays silent until the fault ends, which stands for a power cycle.

    Attributes:
        stored_port: The port it was powered up with; 0 for that of the first start command.
    """

    stored_port: int = within(0, 0, 65_535)


@dataclass(frozen=True, slots=True, kw_only=True)
class SilentStop(Fault):
    """The stream stops without a word.

    Attributes:
        needs_start: After the end it waits for a new start command (assumed), or else goes on by itself.
    """

    needs_start: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleStall(Fault):
    """The console takes what it is told and prints nothing until the end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitConsole(Fault):
    """The console prints in pieces.

    Attributes:
        piece_bytes: Length of a piece.
        gap_s: Time between two.
    """

    piece_bytes: int = within(7, 1, 1024)
    gap_s: float = within(0.001, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleRate(Fault):
    """The unit samples faster or slower than it was told; its stamps stay right (assumed).

    Attributes:
        percent: By so much.
    """

    percent: float = needed(-50.0, 50.0)


KINDS: MappingProxyType[str, type[Fault]] = MappingProxyType(
    {
        "lost_reply": LostReply,
        "bit_flip": BitFlip,
        "late_reply": LateReply,
        "truncated_reply": TruncatedReply,
        "duplicated_reply": DuplicatedReply,
        "foreign_reply": ForeignReply,
        "echo": Echo,
        "silent_servo": SilentServo,
        "brownout": Brownout,
        "overheating": Overheating,
        "overload": Overload,
        "stuck_shaft": StuckShaft,
        "unplug": Unplug,
        "packet_loss": PacketLoss,
        "duplicate_packet": DuplicatePacket,
        "reordered_packet": ReorderedPacket,
        "batching": Batching,
        "mask_change": MaskChange,
        "saturation": Saturation,
        "low_battery": LowBattery,
        "clock_step": ClockStep,
        "rollover": Rollover,
        "port_change_stall": PortChangeStall,
        "silent_stop": SilentStop,
        "console_stall": ConsoleStall,
        "split_console": SplitConsole,
        "sample_rate": SampleRate,
    }
)
