"""What every fault of a scenario has. Times are seconds after the scenario begins.

``rate`` is the probability that one reply or datagram is hit while the fault is on, drawn from the
scenario's seed; ``count`` ends the fault after so many hits, 0 for never.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

from sim_hw.typed_table import within

LONGEST_S = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """When a fault is on.

    Attributes:
        start_s: From then on.
        duration_s: For so long; endless if not given.
        acts_on: Where it is put between the sound devices and the host.
    """

    acts_on: ClassVar[str]
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
