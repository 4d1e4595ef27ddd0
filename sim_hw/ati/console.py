"""The virtual unit's console: echo, lines, prompt. Texts follow a real session with firmware 2.1.27.

Answers to setters that no source shows (T ON, XPWR, FILTER, BIAS) are our own; those to an empty line and
to unknown commands, banner and blank lines are settings in ``sim_hw.assumed.WnetAssumed``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.ati.calibration import AXES
from sim_hw.ati.unit import COUNTS_PER_UNIT, MAX_RATING, VirtualWnet, WnetWire
from sim_hw.interfaces import ConsoleEnd

PROMPT = b">"
BANNER = b"WLAN:  2026 Jan  1 00:00:00 Telnet connection opened by client\r\n\r\n>"
LARGEST_ADC_RATE = 4000
# What some commands print, whatever the unit's state.
FIXED = {
    "VERSIONS": (
        "Component   Version",
        "---------   -------",
        "Firmware    2.1.27 - virtual",
        "WLAN Module 2.6.2.1.7.7",
        "CPLD 0      04",
        "CPLD 1      04",
    ),
    "DEVIP": ("Device IP = 127.0.0.1",),
    "TECHNICIAN": ("USER",),
    "NTP": ("Parameter Value", "--------- -----", "Enable    0"),
    "SAVEALL": ("Saved",),
    "HELP": ("TRANS CALIB CAL RATE XPWR BIAS FILTER T VERSIONS NTP DEVIP HELP",),
}


@dataclass(frozen=True, slots=True)
class CalTable:
    """What CAL prints.

    Attributes:
        transducer: Number.
        calibration: Number of the calibration.
        rows: Gain, offset and six matrix entries of each axis.
        serial: Serial number.
        date: Date.
        part: Part name.
        force: Counts and unit of force, as printed.
        torque: Counts and unit of torque, as printed.
        mult: Matrix on.
        max_rating: Six ratings.
    """

    transducer: int
    calibration: int
    rows: Sequence[tuple[int, int, Sequence[float]]]
    serial: str
    date: str
    part: str
    force: str
    torque: str
    mult: bool
    max_rating: Sequence[float]


def format_cal(table: CalTable) -> list[str]:
    """Return the lines of CAL behind the echo, in the real unit's printf shapes."""
    properties = (
        f"Serial: {table.serial}",
        f"Date:   {table.date}",
        f"Part:   {table.part}",
        f"Force:  {table.force}",
        f"Torque: {table.torque}",
        f"Mult:   {'ON' if table.mult else 'OFF'}",
    )
    lines = [
        "Tr Cal   Gain Offset Row           G0        G1        G2        G3        G4        G5"
        "  Properties",
        "-- ---   ---- ------ ---           --        --        --        --        --        --"
        "  ----------",
    ]
    tr, cal = table.transducer, table.calibration
    for i, (gain, offset, entries) in enumerate(table.rows):
        numbers = " ".join(f"{entry:9.7g}" for entry in entries)
        lines.append(f"{tr:2d} {cal:3d} {gain:6d} {offset:6d} {i:3d} {AXES[i]} {numbers}  "
                     f"{properties[i]}")  # fmt: skip
    lines.append(f"{tr:2d}{0:18d} MaxRatings:")
    first, *rest = table.max_rating
    lines.append(f"{tr:2d}{0:18d}{first:17.7g}" + "".join(f" {r:9.7g}" for r in rest) + " ")
    return lines


class ConsoleSession:
    """``sim_hw.interfaces.ConsoleEnd``: one console session, whose answers are there at once.

    Args:
        unit: The unit.
    """

    def __init__(self, unit: VirtualWnet) -> None:
        self._assumed = unit.assumed
        self._unit = unit
        self._active = 1
        self._line = bytearray()
        self._printed = bytearray(BANNER if unit.assumed.banner else b"")
        self._printed_ns = 0

    def give(self, data: bytes, t_ns: int) -> None:
        """Send bytes to the unit."""
        self._printed_ns = t_ns
        for byte in data:
            if byte == 0x0D or (byte == 0x0A and self._line):
                self._printed += self._obey(self._line.decode("ascii", errors="replace"))
                self._line.clear()
            elif byte != 0x0A:
                self._line.append(byte)

    def take(self, t_ns: int) -> bytes:
        """Return what has been printed."""
        del t_ns
        data = bytes(self._printed)
        self._printed.clear()
        return data

    def next_due_ns(self) -> int | None:
        """When there is something to take."""
        return self._printed_ns if self._printed else None

    def _obey(self, line: str) -> bytes:
        if not line.strip():
            return self._assumed.empty_line.encode("ascii")
        lines = [line, *self._answer(line.split()), *([""] if self._assumed.blank_line else [])]
        return "".join(text + "\r\n" for text in lines).encode("ascii") + PROMPT

    def _answer(self, words: list[str]) -> list[str]:
        actions: dict[str, Callable[[list[str]], list[str]]] = {
            "TRANS": self._trans,
            "CALIB": self._calib,
            "CAL": self._cal,
            "RATE": self._rate,
            "XPWR": self._xpwr,
            "BIAS": self._bias,
            "T": self._transmit,
            "IP": lambda _: [*FIXED["DEVIP"], f"UDPout 49152 -> {self._unit.host_port}"],
            "FILTER": lambda _: self._filter(),
        }
        name = words[0].upper()
        if name in FIXED:
            return list(FIXED[name])
        action = actions.get(name)
        if action is None:
            return [f"{self._assumed.unknown_command}{words[0]}"]
        return action([word.upper() for word in words[1:]])

    def _number(self, words: list[str]) -> int | None:
        if words and words[0].isdecimal() and 1 <= int(words[0]) <= len(self._unit.state):
            return int(words[0])
        return None

    def _trans(self, words: list[str]) -> list[str]:
        number = self._number(words)
        if number is None:
            return ["Error: transducer must be 1 to 6"]
        self._active = number
        return [self._active_line()]

    def _active_line(self) -> str:
        calibration = self._unit.state[self._active - 1].calibration
        return f"Active: Transducer = {self._active} Calibration = {calibration}"

    def _calib(self, words: list[str]) -> list[str]:
        if not words or words[0] not in {"1", "2", "3"}:
            return ["Error: calibration must be 1 to 3"]
        self._unit.state[self._active - 1].calibration = int(words[0])
        return [self._active_line()]

    def _cal(self, words: list[str]) -> list[str]:
        state = self._unit.state[self._active - 1]
        if words[:1] == ["MULT"] and words[1:] in (["ON"], ["OFF"]):
            state.mult = words[1] == "ON"
            return []
        if words:
            return ["Error: not in user mode"]
        return format_cal(nominal_cal(self._active, state.calibration, mult=state.mult))

    def _rate(self, words: list[str]) -> list[str]:
        unit = self._unit
        if words:
            if len(words) != 2 or not all(word.isdecimal() for word in words):
                return ["Error: RATE packets oversampling"]
            rate, oversampling = int(words[0]), int(words[1])
            fits = 5 <= rate <= 4000 and 1 <= oversampling <= 32
            if not fits or rate * oversampling > LARGEST_ADC_RATE:
                return ["Error: rate x oversampling must not exceed 4000"]
            unit.rate_hz, unit.oversampling = rate, oversampling
        return [
            f"Packet rate = {unit.rate_hz:4d} Hz",
            f"ADC    rate = {unit.rate_hz * unit.oversampling:4d} Hz",
            f"Oversample  = {unit.oversampling:4d}",
        ]

    def _xpwr(self, words: list[str]) -> list[str]:
        number = self._number(words)
        if number is not None and words[1:] in (["ON"], ["OFF"]):
            self._unit.state[number - 1].powered = words[1] == "ON"
        lines = ["Tr Auto   Now", "-- ----   ---"]
        for i, state in enumerate(self._unit.state, start=1):
            word = "ON" if state.powered else "OFF"
            lines.append(f"{i:2d} {word:<6} {word}")
        return [*lines, "Analog power = ON in AUTO mode"]

    def _filter(self) -> list[str]:
        rows = [f"{i:2d} MEAN      8" for i in range(1, len(self._unit.state) + 1)]
        return ["Tr Filter  Taps", "-- ------  ----", *rows]

    def _bias(self, words: list[str]) -> list[str]:
        if words and words[-1] in {"ON", "OFF"}:
            numbers = range(1, 7) if words[0] == "*" else [self._number(words) or 1]
            for number in numbers:
                self._unit.set_bias(number, on=words[-1] == "ON")
        rows = [
            f"{i:2d}  1  ON  {'ON' if state.bias is not None else 'OFF'}"
            for i, state in enumerate(self._unit.state, start=1)
        ]
        return ["Tr Ch Pwr   Bias", *rows]

    def _transmit(self, words: list[str]) -> list[str]:
        if words in (["ON"], ["OFF"]):
            self._unit.transmit = words == ["ON"]
        return []


def open_console(wire: WnetWire) -> ConsoleEnd:
    """Return a new console session of the unit at the other end of a wire."""
    return wire.wrap_console(ConsoleSession(wire.unit))


def nominal_cal(number: int, calibration: int, *, mult: bool) -> CalTable:
    """Return the calibration of a virtual transducer: a Gamma SI-130-10, made-up matrix."""
    rows = [
        (600 + i, 32000 + i, [1000.0 if i == j else float(i - j) for j in range(6)])
        for i in range(6)
    ]
    return CalTable(
        transducer=number,
        calibration=calibration,
        rows=rows,
        serial=f"VIRTUAL{number}",
        date="2026/1/1",
        part="SI-130-10",
        force=f"{COUNTS_PER_UNIT} counts/N",
        torque=f"{COUNTS_PER_UNIT} counts/N-m",
        mult=mult,
        max_rating=MAX_RATING,
    )
