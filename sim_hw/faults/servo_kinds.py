"""The faults of the servo bus, one frozen dataclass each."""

from dataclasses import dataclass
from typing import ClassVar

from sim_hw.faults.kinds import ChanceFault, Fault
from sim_hw.typed_table import needed, within

STALL_CURRENT_A = 5.2  # data sheet, at 12 V

# Bytes.


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplyFault(ChanceFault):
    """A fault of servo replies.

    Attributes:
        servo: Id whose replies are hit; all if not given.
    """

    acts_on: ClassVar[str] = "servo bus: each reply"
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

    acts_on: ClassVar[str] = "servo bus: what the host sends"


# Things.


@dataclass(frozen=True, slots=True, kw_only=True)
class SilentServo(Fault):
    """A servo neither hears nor speaks; its motor goes on as it was told last.

    Attributes:
        servo: Its id.
        chain_breaks: In a sync or bulk read, those behind it wait for it and stay silent as well. Both
            were reported of MX servos, so it is a choice.
    """

    acts_on: ClassVar[str] = "servo: its receiver and transmitter"
    servo: int = needed(0, 252)
    chain_breaks: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Brownout(Fault):
    """The servo's supply fails: RAM and turns are lost, and it is gone until the power is back.

    Attributes:
        servo: Its id; all if not given.
    """

    acts_on: ClassVar[str] = "servo: its supply"
    servo: int | None = within(None, 0, 252)


@dataclass(frozen=True, slots=True, kw_only=True)
class Overheating(Fault):
    """The motor is as hot as said, whatever it does.

    Attributes:
        servo: Its id.
        temperature_c: Temperature.
    """

    acts_on: ClassVar[str] = "servo: its temperature sensor"
    servo: int = needed(0, 252)
    temperature_c: float = within(85.0, -20.0, 200.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Overload(Fault):
    """The motor's current is measured as said while torque is on; the servo judges it by its own rule.

    Attributes:
        servo: Its id.
        current_a: Current.
    """

    acts_on: ClassVar[str] = "servo: its current sensor"
    servo: int = needed(0, 252)
    current_a: float = within(STALL_CURRENT_A, -20.0, 20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class StuckShaft(Fault):
    """The shaft is jammed in the plant: dry friction that no servo overcomes.

    Attributes:
        servo: Id of the servo that drives it.
        torque_n_m: The friction.
    """

    acts_on: ClassVar[str] = "plant: the shaft"
    servo: int = needed(0, 252)
    torque_n_m: float = within(50.0, 0.0, 1e3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Unplug(Fault):
    """The USB cable is pulled; at the end it is plugged in again."""

    acts_on: ClassVar[str] = "servo bus: the USB adapter"
