"""Every kind of fault of a scenario: a dataclass each, entered in ``KINDS`` under its name in snake case.

Times are seconds after the scenario begins. ``rate`` is the probability that one request, reply or datagram
is hit while the fault is on, drawn from the scenario's seed; ``count`` ends the fault after so many hits, 0
for never.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, TypeVar, dataclass_transform

from sim_hw.typed_table import among, needed, value, within

STALL_CURRENT_A = 5.2  # data sheet, at 12 V
# Where faults are put between the sound devices and the host.
REQUEST = "servo bus: each request"
REPLY = "servo bus: each reply"
DATAGRAM = "force unit: each datagram"
RECORD = "force unit: each record"
STAMP = "force unit: the stamp of each record"
DATA_PORT = "force unit: its data port"
CONSOLE = "force unit: its console"


@dataclass(frozen=True, slots=True, kw_only=True)
class ScenarioFault:
    """When a fault is on."""

    acts_on: ClassVar[str]
    start_s: float = within(0.0, 0.0, math.inf, "From then on.")
    duration_s: float = within(math.inf, 0.0, math.inf, "For so long; endless if not given.")


@dataclass(frozen=True, slots=True, kw_only=True)
class ChanceFault(ScenarioFault):
    """A fault that hits single requests, replies or datagrams."""

    rate: float = within(1.0, 0.0, 1.0, "Probability of each to be hit.")
    count: int = within(0, 0, 1_000_000_000, "Hits after which it is over, 0 for no end.")


F = TypeVar("F", bound=ScenarioFault)
KINDS: dict[str, type[ScenarioFault]] = {}


@dataclass_transform(frozen_default=True, kw_only_default=True)
def kind(acts_on: str) -> Callable[[type[F]], type[F]]:
    """Enter a class in ``KINDS`` as a frozen dataclass that acts there."""

    def enter(described: type[F]) -> type[F]:
        made = dataclass(frozen=True, slots=True, kw_only=True)(described)
        made.acts_on = acts_on
        KINDS[re.sub(r"\B(?=[A-Z])", "_", made.__name__).lower()] = made
        return made

    return enter


# Requests on the servo bus.


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestFault(ChanceFault):
    """A fault of the host's requests."""

    servo: int | None = within(
        None, 0, 252, "Id whose requests are hit; all, broadcasts among them, if not given."
    )


@kind(REQUEST)
class LostRequest(RequestFault):
    """No servo receives the request."""


@kind(REQUEST)
class DamagedRequest(RequestFault):
    """One bit of the request is inverted on the wire."""

    bit: int = within(
        -1, -1, 32_767, "Which, from the lowest bit of the first byte; -1 draws one each time."
    )


@kind(REQUEST)
class LateRequest(RequestFault):
    """The request is late on the wire, where its answer may meet the next one."""

    delay_s: float = within(0.005, 0.0, 10.0, "By so much.")


@kind(REQUEST)
class TruncatedRequest(RequestFault):
    """Only the beginning of the request reaches the servos."""

    keep_bytes: int = within(-1, -1, 4096, "So many bytes of it; -1 for half.")


# Replies on the servo bus.


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplyFault(ChanceFault):
    """A fault of servo replies."""

    servo: int | None = within(None, 0, 252, "Id whose replies are hit; all if not given.")


@kind(REPLY)
class LostReply(ReplyFault):
    """The reply never arrives."""


@kind(REPLY)
class BitFlip(ReplyFault):
    """One bit of the reply arrives inverted."""

    bit: int = within(
        -1, -1, 32_767, "Which, from the lowest bit of the first byte; -1 draws one for each reply."
    )


@kind(REPLY)
class LateReply(ReplyFault):
    """The reply arrives late, kept by adapter or host; others do not wait for it."""

    delay_s: float = within(0.03, 0.0, 10.0, "By so much.")


@kind(REPLY)
class TruncatedReply(ReplyFault):
    """Only the beginning of the reply arrives."""

    keep_bytes: int = within(-1, -1, 4096, "So many bytes of it; -1 for half.")


@kind(REPLY)
class DuplicatedReply(ReplyFault):
    """The reply arrives twice in a row."""


@kind(REPLY)
class ForeignReply(ReplyFault):
    """A status of another id, that nobody asked, comes before the reply."""

    foreign_id: int = within(99, 0, 252, "That id.")


@kind("servo bus: what the host sends")
class Echo(ChanceFault):
    """The host receives its own request, as with an adapter that does not switch its receiver off."""


# Servos, shafts and the cable.


@kind("servo: its receiver and transmitter")
class SilentServo(ScenarioFault):
    """A servo neither receives nor answers; its motor goes on as it was told last."""

    servo: int = needed(0, 252, "Its id.")
    # both were reported of MX servos
    chain_breaks: bool = value(False, "Those behind it in a sync or bulk read stay silent as well.")


@kind("servo: its supply")
class Brownout(ScenarioFault):
    """The servo's supply fails: RAM and turns are lost, and it is gone until the power is back."""

    servo: int | None = within(None, 0, 252, "Its id; all if not given.")


@kind("servo: its temperature sensor")
class Overheating(ScenarioFault):
    """The motor is as hot as said, whatever it does."""

    servo: int = needed(0, 252, "Its id.")
    temperature_c: float = within(85.0, -20.0, 200.0, "Temperature.")


@kind("servo: its current sensor")
class Overload(ScenarioFault):
    """The motor's current is measured as said while torque is on; the servo judges it by its own rule."""

    servo: int = needed(0, 252, "Its id.")
    current_a: float = within(STALL_CURRENT_A, -20.0, 20.0, "Current.")


@kind("plant: the shaft")
class StuckShaft(ScenarioFault):
    """The shaft is jammed in the plant: dry friction that no servo overcomes."""

    servo: int = needed(0, 252, "Id of the servo that drives it.")
    torque_n_m: float = within(50.0, 0.0, 1e3, "The friction.")


@kind("servo bus: the USB adapter")
class Unplug(ScenarioFault):
    """The USB cable is pulled; at the end it is plugged in again."""


# The force-torque unit.


@kind(DATAGRAM)
class PacketLoss(ChanceFault):
    """A datagram is lost in the air."""


@kind(DATAGRAM)
class DuplicatePacket(ChanceFault):
    """A datagram arrives twice."""


@kind(DATAGRAM)
class ReorderedPacket(ChanceFault):
    """A datagram arrives behind the next one."""


@kind("force unit: how records go into datagrams")
class Batching(ScenarioFault):
    """Several records come in one datagram. When the real unit does so is not known."""

    records: int = within(
        3, 1, 24, "How many; ATI's receive buffer holds six records of six transducers."
    )


@kind(RECORD)
class MaskChange(ScenarioFault):
    """Transducers vanish from the records, as when they are switched off."""

    transducers: tuple[int, ...] = needed(1, 6, "Their numbers, from 1.")


@kind(RECORD)
class Saturation(ScenarioFault):
    """A transducer reports saturation: its bit is set and its LED is red."""

    transducer: int = needed(1, 6, "Its number, from 1.")
    counts: int = within(
        2**31 - 1, -(2**31), 2**31 - 1, "What all its axes then read; 2^31 - 1 is assumed."
    )


@kind(RECORD)
class LowBattery(ScenarioFault):
    """The battery runs low: there is no flag, only the LED and a byte of unknown scale."""

    level: int = within(1, 0, 255, "The battery byte; assumed.")
    led: str = among("red", "orange", "off", "green", text="The battery LED; red is assumed.")


@kind(STAMP)
class ClockStep(ScenarioFault):
    """The unit's clock jumps, as when NTP finds its server, and jumps back at the end."""

    step_s: float = needed(-524_288.0, 524_288.0, "By so much.")


@kind(STAMP)
class Rollover(ScenarioFault):
    """The unit's stamps, which wrap every 12.1 days, wrap in this run.

    That is ``start_s`` after its first record, not after the scenario's beginning, because a clock does not
    know of that; before it the stamps count up to the wrap. It has no end, and only the first one counts.
    """


@kind(DATA_PORT)
class PortChangeStall(ScenarioFault):
    """Asked to send to another host port than at power-up, the unit closes one and opens none.

    It stays silent until the fault ends, which stands for a power cycle.
    """

    stored_port: int = within(
        0, 0, 65_535, "The port it was powered up with; 0 for that of the first start command."
    )


@kind(DATA_PORT)
class SilentStop(ScenarioFault):
    """The stream stops without a word."""

    needs_start: bool = value(
        True, "After the end it waits for a new start command (assumed), or else goes on by itself."
    )


@kind(CONSOLE)
class ConsoleStall(ScenarioFault):
    """The console takes what it is told and prints nothing until the end."""


@kind(CONSOLE)
class SplitConsole(ScenarioFault):
    """The console prints in pieces."""

    piece_bytes: int = within(7, 1, 1024, "Length of a piece.")
    gap_s: float = within(0.001, 0.0, 1.0, "Time between two.")


@kind("force unit: its sample clock")
class SampleRate(ScenarioFault):
    """The unit samples faster or slower than it was told; its stamps stay right (assumed)."""

    percent: float = needed(-50.0, 50.0, "By so much.")
