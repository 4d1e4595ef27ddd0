"""Faults inside the records of the force-torque unit: bytes in, bytes out."""

from collections.abc import Sequence
from dataclasses import replace

from drivers.ati.packets import TICKS_PER_SECOND, U32, Malformed, build_record, parse_datagram
from model.values.readings import ForceRecord
from sim_hw.faults.kinds import (
    ClockStep,
    LowBattery,
    MaskChange,
    Rollover,
    Saturation,
    ScenarioFault,
)
from sim_hw.faults.time import ScenarioTime

LED_CODES = {"off": 0, "red": 1, "green": 2, "orange": 3}
BATTERY_LED_SHIFT = 10
CHANNELS = 3  # of each status word
SATURATED_BIT = 24
# Of channel 0 of a status word: LED pair; AFE and BRIDGE; saturated; bridge voltage low.
LED_MASK, AFE_MASK, SATURATED_MASK, BRIDGE_LOW_MASK = 0x3, 0x3_0000, 0x100_0000, 0x800_0000


class RecordFaults:
    """Changes records as the faults that are on say.

    Args:
        faults: All faults of the scenario.
        time: The scenario's time.
    """

    def __init__(self, faults: Sequence[ScenarioFault], time: ScenarioTime) -> None:
        kinds = (MaskChange, Saturation, LowBattery, ClockStep)
        self._faults = [fault for fault in faults if isinstance(fault, kinds)]
        self._rollovers = [fault for fault in faults if isinstance(fault, Rollover)]
        self._time = time
        self._shift_ticks: int | None = None

    def change(self, t_ns: int, data: bytes) -> bytes:
        """Return a record as it is sent."""
        active = [fault for fault in self._faults if self._time.active(fault, t_ns)]
        if not active and not self._rollovers:
            return data
        parsed = parse_datagram(data, t_ns)
        if isinstance(parsed, Malformed):
            raise ValueError(f"the virtual unit sent what is no record: {parsed.reason}")
        record = self._roll_over(parsed[0])
        for fault in active:
            record = _changed(record, fault)
        return build_record(record)

    def _roll_over(self, record: ForceRecord) -> ForceRecord:
        """Shift the unit's clock so that it wraps when told."""
        if not self._rollovers:
            return record
        if self._shift_ticks is None:
            wrap_s = self._rollovers[0].start_s
            self._shift_ticks = -(record.device_ticks + round(wrap_s * TICKS_PER_SECOND))
        return replace(record, device_ticks=(record.device_ticks + self._shift_ticks) % U32)


def _changed(record: ForceRecord, fault: ScenarioFault) -> ForceRecord:
    match fault:
        case MaskChange():
            for number in fault.transducers:
                record = _without(record, number)
            return record
        case Saturation():
            return _saturated(record, fault)
        case LowBattery():
            words = record.status.copy()
            led = LED_CODES[fault.led] << BATTERY_LED_SHIFT
            words[0] = words[0] & ~(LED_MASK << BATTERY_LED_SHIFT) | led
            return replace(record, status=words, battery=fault.level)
        case ClockStep():
            step = round(fault.step_s * TICKS_PER_SECOND)
            return replace(record, device_ticks=(record.device_ticks + step) % U32)
        case _:
            return record


def _without(record: ForceRecord, number: int) -> ForceRecord:
    """Take a transducer out: its block, its mask bit, and all its status bits."""
    present, words = record.present.copy(), record.status.copy()
    present[number - 1] = False
    word, channel = divmod(number - 1, CHANNELS)
    gone = (LED_MASK | AFE_MASK) << 2 * channel | (SATURATED_MASK | BRIDGE_LOW_MASK) << channel
    words[word] &= ~gone
    return replace(record, present=present, status=words, mask=record.mask & ~(1 << number - 1))


def _saturated(record: ForceRecord, fault: Saturation) -> ForceRecord:
    number = fault.transducer
    if not record.present[number - 1]:
        return record
    counts, words = record.counts.copy(), record.status.copy()
    counts[number - 1] = fault.counts
    word, channel = divmod(number - 1, CHANNELS)
    red = LED_CODES["red"] << 2 * channel
    words[word] = words[word] & ~(LED_MASK << 2 * channel) | red | 1 << SATURATED_BIT + channel
    return replace(record, counts=counts, status=words)
