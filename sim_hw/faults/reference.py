"""What a scenario file may say: every kind of fault and every setting, with unit, default and bounds.

Read off the dataclasses that ``sim_hw.faults.scenario`` fills, so that it cannot say anything else than
they do.
"""

import dataclasses
import inspect
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from sim_hw.assumed import AdapterAssumed, ImuAssumed, ServoAssumed, WnetAssumed
from sim_hw.faults.kinds import KINDS, ScenarioFault
from sim_hw.faults.scenario import Course

# What the ending of a name says about its unit.
UNITS = (
    ("_rad_s", "rad/s"),
    ("_rad", "rad"),
    ("_n_m", "N m"),
    ("_s", "s"),
    ("_c", "degC"),
    ("_a", "A"),
    ("_hz", "Hz"),
    ("percent", "%"),
    ("_bytes", "bytes"),
    ("rate", "probability"),
    ("counts", "counts"),
)
NO_UNIT = ""


@dataclass(frozen=True, slots=True)
class Setting:
    """One key of a table.

    Attributes:
        name: The key.
        unit: Its unit, empty if it has none.
        default: Its default in words, empty if the file must give it.
        allowed: What it may be, in words.
        text: What it means.
    """

    name: str
    unit: str
    default: str
    allowed: str
    text: str

    @property
    def needed(self) -> bool:
        """Whether the file must give it."""
        return not self.default


@dataclass(frozen=True, slots=True)
class KindOfFault:
    """One kind of fault.

    Attributes:
        kind: Its name.
        acts_on: Where it acts.
        text: What it does.
        settings: Its own keys, without those of every fault.
        chance: Whether it hits single replies or datagrams, and so has ``rate`` and ``count``.
    """

    kind: str
    acts_on: str
    text: str
    settings: tuple[Setting, ...]
    chance: bool


@dataclass(frozen=True, slots=True)
class ReferenceTable:
    """One table of a scenario file besides the faults.

    Attributes:
        name: Its name, empty for the top of the file.
        text: What it is about.
        settings: Its keys.
    """

    name: str
    text: str
    settings: tuple[Setting, ...]


COMMON = ("start_s", "duration_s", "rate", "count")


def kinds_of_fault() -> tuple[KindOfFault, ...]:
    """Return every kind of fault, in the order of the catalogue."""
    return tuple(_kind(name, fault) for name, fault in KINDS.items())


def common_settings() -> tuple[Setting, ...]:
    """Return the keys that every fault has, and the two of those that hit single replies."""
    every = {s.name: s for fault in KINDS.values() for s in _settings(fault)}
    return tuple(every[name] for name in COMMON)


def tables() -> tuple[ReferenceTable, ...]:
    """Return the tables besides the faults."""
    kinds: tuple[tuple[str, type], ...] = (
        ("", Course),
        ("servo", ServoAssumed),
        ("force_unit", WnetAssumed),
        ("adapter", AdapterAssumed),
        ("imu", ImuAssumed),
    )
    return tuple(ReferenceTable(name, _summary(kind), _settings(kind)) for name, kind in kinds)


def _kind(name: str, fault: type[ScenarioFault]) -> KindOfFault:
    settings = _settings(fault)
    own = tuple(s for s in settings if s.name not in COMMON)
    return KindOfFault(name, fault.acts_on, _summary(fault), own, len(settings) - len(own) > 2)


def _summary(kind: type) -> str:
    return " ".join((inspect.getdoc(kind) or "").replace("``", "").split())


def _settings(kind: type) -> tuple[Setting, ...]:
    types = get_type_hints(kind)
    return tuple(
        Setting(
            name=field.name,
            unit=_unit(field.name),
            default=_default(field.default),
            allowed=_allowed(types[field.name], field.metadata),
            text=field.metadata["text"].replace("``", ""),
        )
        for field in dataclasses.fields(kind)
    )


def _unit(name: str) -> str:
    return next((unit for ending, unit in UNITS if name.endswith(ending)), NO_UNIT)


def _default(value: Any) -> str:
    if value is dataclasses.MISSING:
        return ""
    if value is None:
        return "all"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, tuple):
        return str(list(value))
    return "no end" if isinstance(value, float) and math.isinf(value) else f"{value:.10g}"


def _allowed(kind: Any, bounds: Mapping[str, Any]) -> str:
    if kind is bool:
        return "true or false"
    if kind is str:
        return ", ".join(bounds["choices"]) if "choices" in bounds else "text"
    low, high = bounds["low"], bounds["high"]
    words = f"from {low:.10g} on" if math.isinf(high) else f"{low:.10g} to {high:.10g}"
    return f"list, each {words}" if kind == tuple[int, ...] else words
