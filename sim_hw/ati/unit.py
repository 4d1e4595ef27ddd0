"""The virtual wireless force-torque unit: commands in, records out on schedule, a console beside.

No input or output of its own: ``sim_hw.ati.sockets`` and ``sim_hw.ati.memory`` carry its bytes. What no
source tells (does a start reset the sequence number? are commands acknowledged?) is a setting in
``sim_hw.assumed.WnetAssumed``.
"""

import math
from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from drivers.ati.packets import (
    AXES,
    TRANSDUCERS,
    U32,
    UnitCommand,
    build_record,
    device_ticks,
    flags,
    parse_command,
)
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.readings import ForceRecord
from sim_hw.assumed import WNET_ASSUMED, WnetAssumed
from sim_hw.ati import record_kernel
from sim_hw.ati.record_kernel import sensed_counts
from sim_hw.interfaces import ConsoleEnd, WrenchSource

DEFAULT_RATE_HZ = 125
DEFAULT_OVERSAMPLING = 32
COUNTS_PER_UNIT = 1_000_000
# ATI Gamma SI-130-10.
MAX_RATING = (130.0, 130.0, 400.0, 10.0, 10.0, 10.0)
RATING = np.array(MAX_RATING)
# AFE bits and green LEDs of powered channels: as seen on a real unit.
AFE = (0x0001_0000, 0x0004_0000, 0x0010_0000)
LED_GREEN = 0b10
# Standard deviation of the sensor's noise at 100 Hz, near the Gamma's resolution [N, N m].
NOISE = (0.02, 0.02, 0.04, 0.001, 0.001, 0.001)


# The factory's; what it does at 100 Hz is in the noise of the sensor.
USUAL_FILTER = ("MEAN", 8)


@dataclass(slots=True)
class TransducerState:
    """One transducer as its owner has set it up.

    Attributes:
        powered: Whether it has power, and so appears in records.
        mult: Whether it sends forces or raw gage counts.
        calibration: Number of the active calibration.
        bias: Counts subtracted by the unit itself.
        filter: Kind of the unit's own filter, and its taps or constant.
        filtered: What a filter other than the usual one gave last; None before the first sample.
    """

    powered: bool
    mult: bool = True
    calibration: int = 1
    bias: IntArray | None = None
    filter: tuple[str, int] = USUAL_FILTER
    filtered: FloatArray | None = None


class WnetWire(Protocol):
    """The force-torque unit as the host's end sees it: commands in, datagrams out, a console beside."""

    @property
    def unit(self) -> "VirtualWnet":
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


class VirtualWnet:
    """The unit.

    Args:
        source: Where wrenches come from, one a leg.
        transducers: Transducer number of each leg, 1 to 6, 0 for none.
        seed: Seed of the noise.
        noise: Standard deviation of each axis; zeros give exact counts.
        unix_offset_ns: UNIX time minus the clock it is polled with.
        assumed: What is assumed about it.

    Attributes:
        sampling_ratio: Records sent a second over records asked for; 1 for a perfect crystal.
        host_port: Port that records go to, 0 before the first start.
    """

    def __init__(
        self,
        source: WrenchSource,
        transducers: tuple[int, ...],
        *,
        seed: int = 0,
        noise: tuple[float, ...] = NOISE,
        unix_offset_ns: int = 1_700_000_000_000_000_000,
        assumed: WnetAssumed = WNET_ASSUMED,
    ) -> None:
        record_kernel.prepare()
        self.assumed = assumed
        self.sampling_ratio = 1.0
        self.host_port = 0
        self.rate_hz = DEFAULT_RATE_HZ
        self.oversampling = DEFAULT_OVERSAMPLING
        self.transmit = True
        self.ignored = 0
        self.state = [
            TransducerState(powered=number in transducers) for number in range(1, TRANSDUCERS + 1)
        ]
        self._source = source
        numbers = np.array(transducers, dtype=np.int64)
        self._used: IntArray = np.flatnonzero(numbers > 0)  # legs that have a transducer
        self._slots: IntArray = numbers[self._used] - 1
        self._slot_list: list[int] = self._slots.tolist()
        self._random = np.random.default_rng(seed)
        self._noise = np.array(noise)
        self._unix_offset_ns = unix_offset_ns
        self._sequence = 0
        self._recent_counts: deque[IntArray] = deque(maxlen=assumed.bias_samples)
        self._acknowledgements: list[tuple[int, bytes]] = []
        self._left = 0  # samples to send; -1 endless
        self._next_ns = 0
        self.console_reset = False

    # Commands.

    @property
    def unit(self) -> "VirtualWnet":
        """The unit itself; see ``WnetWire``."""
        return self

    def wrap_console(self, end: ConsoleEnd) -> ConsoleEnd:
        """Return a console session as it is."""
        return end

    def command(self, data: bytes, t_ns: int, host_port: int) -> bool:
        """Take a command sent from a port; return whether that becomes the receiver of records."""
        command = parse_command(data)
        if command is None:
            self.ignored += 1
            return False
        if self.assumed.acknowledges:
            self._acknowledgements.append((t_ns, data))
        if command.command == UnitCommand.START:
            self._left = command.samples if command.samples > 0 else -1
            self._next_ns = t_ns + self._period_ns
            if self.assumed.sequence_restarts:
                self._sequence = 0
            self.host_port = host_port
            return True
        if command.command == UnitCommand.STOP:
            self._left = 0
        elif command.command == UnitCommand.RESET_CONSOLE:
            self.console_reset = True
        return False

    @property
    def _period_ns(self) -> int:
        period_s = 1.0 / self.rate_hz
        tick_hz = self.assumed.adc_clock_hz
        if tick_hz:
            period_s = max(1, round(period_s * tick_hz)) / tick_hz
        return round(1e9 * period_s / self.sampling_ratio)

    @property
    def streaming(self) -> bool:
        """Whether records are due."""
        return self.transmit and self._left != 0

    def next_due_ns(self) -> int | None:
        """When the next record is due, None if none is."""
        if self._acknowledgements:
            return self._acknowledgements[0][0]
        return self._next_ns if self.streaming else None

    # Records.

    def poll(self, t_ns: int) -> list[tuple[int, bytes]]:
        """Return the records due by a time: when each was sampled, and its bytes."""
        acknowledgements, self._acknowledgements = self._acknowledgements, []
        due = [(record.t_ns, build_record(record)) for record in self.due(t_ns)]
        return acknowledgements + due

    def due(self, t_ns: int) -> list[ForceRecord]:
        """Return the records due by a time before they are made bytes, stamped when they were sampled."""
        records: list[ForceRecord] = []
        while self.streaming and self._next_ns <= t_ns:
            records.append(self._record(self._next_ns))
            self._next_ns += self._period_ns
            if self._left > 0:
                self._left -= 1
        return records

    def _record(self, t_ns: int) -> ForceRecord:
        wrench = self._source.wrench(t_ns)
        counts = np.zeros((TRANSDUCERS, AXES), dtype=np.int64)
        chance = self._random.standard_normal((TRANSDUCERS, AXES))
        within = sensed_counts(
            wrench, chance, self._noise, RATING, self._used, self._slots, COUNTS_PER_UNIT, counts
        )
        usual = within
        for slot in self._slot_list if within else ():
            usual = usual and self.state[slot].filter == USUAL_FILTER
        # slots of transducers that are saturated
        over = () if usual else self._bounded_counts(wrench, chance * self._noise, counts)
        for slot in self._slot_list:
            bias = self.state[slot].bias
            if bias is not None:
                counts[slot] -= bias
        self._sequence = (self._sequence + 1) % U32
        powered = tuple([state.powered for state in self.state])
        status, mask, present, saturated = _condition(powered, over, self.assumed.extra_status)
        record = ForceRecord(
            t_ns=t_ns,
            device_ticks=device_ticks(t_ns + self._unix_offset_ns),
            sequence=self._sequence,
            status=status,
            battery=self.assumed.battery,
            mask=mask,
            counts=counts,
            present=present,
            saturated=saturated,
        )
        self._recent_counts.append(counts)
        return record

    def _bounded_counts(
        self, wrench: FloatArray, noise: FloatArray, counts: IntArray
    ) -> tuple[int, ...]:
        """Write counts that were filtered otherwise or are bounded; return the slots beyond a bound."""
        sensed = wrench.take(self._used, axis=0) + noise.take(self._slots, axis=0)
        beyond = np.abs(sensed) > RATING
        for row, slot in enumerate(self._slot_list):
            if self.state[slot].filter != USUAL_FILTER:
                sensed[row] = self._filtered(self.state[slot], sensed[row])
        # what a filter remembers may be beyond them
        sensed = np.minimum(np.maximum(sensed, -RATING), RATING)
        counts[self._slots] = np.rint(sensed * COUNTS_PER_UNIT)
        return tuple(self._slots[beyond.any(axis=1)].tolist())

    def _filtered(self, state: TransducerState, sensed: FloatArray) -> FloatArray:
        """What the transducer's filter makes of a sample: a first-order lag of the filter's mean delay."""
        kind, taps = state.filter
        adc_hz = self.rate_hz * self.oversampling
        delay_s = (taps if kind == "IIR" else (taps - 1) / 2) / adc_hz
        share = 1.0 - math.exp(-1.0 / (self.rate_hz * delay_s)) if delay_s > 0 else 1.0
        before = sensed if state.filtered is None else state.filtered
        state.filtered = before + share * (sensed - before)
        return state.filtered

    def set_bias(self, number: int, *, on: bool) -> None:
        """Take the last counts of a transducer as its zero, or forget that zero."""
        state, recent = self.state[number - 1], self._recent_counts
        if not on or not recent:
            state.bias = None
            return
        # records hold what is left of an older bias
        seen = np.mean([counts[number - 1] for counts in recent], axis=0)
        older = 0 if state.bias is None else state.bias
        state.bias = np.rint(seen).astype(np.int64) + older


@lru_cache(maxsize=16)
def _condition(
    powered: tuple[bool, ...], over: tuple[int, ...], extra: int
) -> tuple[IntArray, int, BoolArray, BoolArray]:
    """Return what a record says of its transducers; the same in nearly every record.

    Args:
        powered: Of each slot.
        over: Slots of those that are saturated.
        extra: Further bits of the first status word.

    Returns:
        The two status words, (2,); the mask; who is present and who is saturated, (6,) each.
    """
    saturated = tuple(slot in over for slot in range(TRANSDUCERS))
    words = []
    for half in (0, 3):
        word = 0
        for i in range(3):
            if powered[half + i]:
                word |= AFE[i] | LED_GREEN << 2 * i
            if saturated[half + i]:
                word |= 1 << 24 + i
        words.append(word | (0xA80 | extra if half == 0 else 0))
    status: IntArray = readonly(np.array(words))
    mask = sum(1 << i for i, on in enumerate(powered) if on)
    return status, mask, flags(powered), flags(saturated)
