"""What in the unit changes its data and is in no record: rate, filters, device bias, power, firmware.

The unit keeps all of it from one user to the next. A filter that somebody left on looks like a delay of the
robot, a device bias like another zero. So it is asked for at every start, judged, and kept with the run.
Sources of the tables: ATI's Java demo and transcripts of firmware 2.1.27; what an unknown filter constant
does is not known.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from drivers.ati.console import Console
from drivers.ati.settings import ForceSensorSettings
from model.errors import ForceStreamError

# A mean over so many of the unit's own samples is what the factory sets.
USUAL_TAPS = 8
STATE_COMMANDS = ("RATE", "XPWR", "FILTER", "BIAS", "VERSIONS")
_RATE = re.compile(r"Packet\s+rate\s*=\s*(\d+)")
_OVERSAMPLING = re.compile(r"Oversample\s*=\s*(\d+)")
_FILTER = re.compile(r"^\s*(\d)\s+([A-Z]+)\s+(-?\d+)\s*$", re.MULTILINE)
_BIAS = re.compile(r"^\s*(\d)\s+\d+\s+\S+\s+(ON|OFF)\s*$", re.MULTILINE)
_POWER = re.compile(r"^\s*(\d)\s+(?:ON|OFF)\s+(ON|OFF)\s*$", re.MULTILINE)
_FIRMWARE = re.compile(r"^Firmware\s+(.+?)\s*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class UnitState:
    """What the console says of the unit. What it did not say is None, or missing from a table.

    Attributes:
        rate_hz: Packets a second.
        oversampling: Samples a packet.
        filters: Filter and its taps (or constant), by transducer.
        biased: Transducers whose device bias is on.
        unpowered: Transducers without power.
        firmware: Firmware, as printed; empty if it was not.
    """

    rate_hz: int | None
    oversampling: int | None
    filters: tuple[tuple[int, str, int], ...]
    biased: tuple[int, ...]
    unpowered: tuple[int, ...]
    firmware: str

    @property
    def text(self) -> str:
        """All of it in one line, for the log."""
        filters = ", ".join(f"{number} {kind} {taps}" for number, kind, taps in self.filters)
        return (
            f"rate {self.rate_hz} x {self.oversampling}; filter {filters or 'unknown'}; "
            f"bias on: {_numbers(self.biased)}; no power: {_numbers(self.unpowered)}; "
            f"firmware {self.firmware or 'unknown'}"
        )

    def concerns(self, settings: ForceSensorSettings) -> tuple[tuple[str, str], ...]:
        """Return what changes the forces of this robot's transducers: console command and sentence."""
        used = {int(number) for number in settings.transducers if number}
        concerns: list[tuple[str, str]] = []
        if biased := used & set(self.biased):
            sentence = (
                f"device bias is on for transducer {_numbers(sorted(biased))}: forces count from "
                "where they stood when it was switched on; switch it off with: bigant force bias "
                "--device-off"
            )
            concerns.append(("BIAS", sentence))
        adc_hz = (self.rate_hz or settings.rate_hz) * (self.oversampling or settings.oversampling)
        for number, kind, taps in self.filters:
            if number not in used or (kind == "MEAN" and taps <= USUAL_TAPS):
                continue
            late = (
                f"by about {(taps - 1) / 2 / adc_hz * 1e3:.1f} ms" if kind != "IIR" else "by more"
            )
            sentence = (
                f"transducer {number} has the filter {kind} {taps}, which delays forces {late}; set "
                f"the usual one on the unit's console with: FILTER {number} MEAN {USUAL_TAPS}"
            )
            concerns.append(("FILTER", sentence))
        if dark := used & set(self.unpowered):
            sentence = (
                f"transducer {_numbers(sorted(dark))} has no power: switch it on with XPWR n ON on "
                "the unit's console"
            )
            concerns.append(("XPWR", sentence))
        return tuple(concerns)

    def warnings(self, settings: ForceSensorSettings) -> tuple[str, ...]:
        """Return the sentences of ``concerns``."""
        return tuple(sentence for _, sentence in self.concerns(settings))


def read_unit_state(console: Console) -> UnitState:
    """Ask the console for all of it; changes nothing.

    Raises:
        ForceStreamError: It does not answer.
    """
    return parse_unit_state({command: console.query(command) for command in STATE_COMMANDS})


def parse_unit_state(answers: Mapping[str, str]) -> UnitState:
    """Return what the console's answers to ``STATE_COMMANDS`` say."""
    firmware = _FIRMWARE.search(answers["VERSIONS"])
    return UnitState(
        rate_hz=_first(_RATE, answers["RATE"]),
        oversampling=_first(_OVERSAMPLING, answers["RATE"]),
        filters=tuple(
            (int(n), kind, int(taps)) for n, kind, taps in _FILTER.findall(answers["FILTER"])
        ),
        biased=_numbers_where(_BIAS, answers["BIAS"], "ON"),
        unpowered=_numbers_where(_POWER, answers["XPWR"], "OFF"),
        firmware=firmware.group(1) if firmware else "",
    )


def set_rate(console: Console, rate_hz: int, oversampling: int) -> None:
    """Set the rate, and see that it is what the unit says afterwards.

    Raises:
        ForceStreamError: It has another one.
    """
    answer = console.query(f"RATE {rate_hz} {oversampling}")
    there = _first(_RATE, answer), _first(_OVERSAMPLING, answer)
    if there != (rate_hz, oversampling):
        raise ForceStreamError(
            f"the force-torque unit does not take rate {rate_hz} x {oversampling}: it says "
            f"{' '.join(answer.split()) or 'nothing'}; choose another rate in the robot file"
        )


def _first(pattern: re.Pattern[str], text: str) -> int | None:
    match = pattern.search(text)
    return int(match.group(1)) if match else None


def _numbers_where(pattern: re.Pattern[str], text: str, word: str) -> tuple[int, ...]:
    return tuple(int(number) for number, state in pattern.findall(text) if state == word)


def _numbers(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "none"
