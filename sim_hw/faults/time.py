"""When the faults of a scenario are on, and the dice that decide which reply is hit."""

import math
from collections.abc import Sequence

import numpy as np

from sim_hw.faults.kinds import ChanceFault, ScenarioFault


class ScenarioTime:
    """The time of a scenario, shared by all devices of one robot.

    Args:
        begins: ``power`` or ``torque``; see ``sim_hw.faults.scenario``.
    """

    def __init__(self, begins: str) -> None:
        self._needs_torque = begins == "torque"
        self._zero_ns: int | None = None
        self._spans: dict[int, tuple[ScenarioFault, int | None, int | None]] = {}

    def look(self, t_ns: int, *, torque: bool) -> None:
        """Begin at ``t_ns`` if it has not begun and what it waits for is there."""
        if self._zero_ns is None and (torque or not self._needs_torque):
            self._zero_ns = t_ns

    @property
    def begun(self) -> bool:
        """Whether second 0 is known."""
        return self._zero_ns is not None

    def end_ns(self, fault: ScenarioFault) -> int | None:
        """When a fault ends, None if that is not known or never."""
        return self._span(fault)[2]

    def _span(self, fault: ScenarioFault) -> tuple[ScenarioFault, int | None, int | None]:
        """Start and end, computed once; asked for with every byte on the wire."""
        span = self._spans.get(id(fault))
        if span is None:
            span = fault, self._at(fault.start_s), self._at(fault.start_s + fault.duration_s)
            if self._zero_ns is not None:
                self._spans[id(fault)] = span
        return span

    def _at(self, after_s: float) -> int | None:
        if self._zero_ns is None or not math.isfinite(after_s):
            return None
        return self._zero_ns + round(after_s * 1e9)

    def active(self, fault: ScenarioFault, t_ns: int) -> bool:
        """Whether a fault is on: from its start on, and no more at its end."""
        _, start_ns, end_ns = self._span(fault)
        return start_ns is not None and start_ns <= t_ns and (end_ns is None or t_ns < end_ns)

    def changes(self, faults: Sequence[ScenarioFault], after_ns: int, until_ns: int) -> list[int]:
        """Return the times in (after, until] at which a fault starts or ends, in order."""
        times = {t for fault in faults for t in self._span(fault)[1:]}
        return sorted(t for t in times if t is not None and after_ns < t <= until_ns)


class Dice:
    """Decides which replies or datagrams a fault hits; each fault has a generator of its own.

    Args:
        fault: The fault.
        time: The scenario's time.
        seed: The scenario's seed.
        index: Place of the fault in the scenario.
    """

    def __init__(self, fault: ChanceFault, time: ScenarioTime, seed: int, index: int) -> None:
        self.fault = fault
        self.random = np.random.default_rng([seed, index])
        self._time = time
        self._hits = 0

    def hits(self, t_ns: int) -> bool:
        """Whether what passes at a time is hit."""
        fault = self.fault
        if not self._time.active(fault, t_ns) or (fault.count and self._hits >= fault.count):
            return False
        if fault.rate < 1.0 and self.random.random() >= fault.rate:
            return False
        self._hits += 1
        return True
