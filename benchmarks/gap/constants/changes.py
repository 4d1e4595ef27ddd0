"""Half and twice of each constant of ``gap.constants``, and what these are of a share or of log odds."""

import math
from dataclasses import dataclass

from gap import constants
from gap.constants import Constant

# doubled, these would reach 1 or more: half of the way to 1 instead
SHARES = frozenset({
    "SHOWN", "MOSTLY", "WHOLE_SHARE", "NONE_LIKELY", "HUNTS_KEEPS", "HUNTS_ALWAYS", "PLACE_SHARE",
    "CONTAINS_SHARE", "CAUSES_PART", "EVEN_CHANGE", "OWN_POWER", "MUCH_LESS", "NEAR_AS_GOOD",
    "MAY_REACH", "LAST_BLOCK", "GRIP_LARGEST",
})  # fmt: skip
# half of the frames a second is the fastest that frames show: half of the way to it
OF_FRAMES = frozenset({"VIBRATES_FASTER"})
# half and twice the odds: their logarithm less and more by ln 2
LOG_ODDS = frozenset({"NONE"})

# these act on nothing before the probabilities: known answers can be judged again with them
OF_PROBABILITIES = (
    "TEMPERATURE", "ERROR_SHARE", "MISFIT_SHARE", "GAIN_SHARE", "NONE", "NONE_ENERGY", "NONE_OPEN",
    "NONE_OPEN_ALONE", "NONE_WORST", "NONE_WORST_ALONE", "NONE_MANY", "NONE_ACTING", "NONE_LEFT",
    "NONE_UNWATCHED", "EVEN_CHANGE",
    "SURELY_ODD", "NONE_LIKELY", "UNSTEADY_LEVEL", "UNSTEADY_GROWTH",
)  # fmt: skip

# only legged robots have what these act on: they are judged on cases of such robots
OF_LEGGED = (
    "EDGE_S", "SWITCH_S", "SWITCH_WEIGHT", "CONTACT_N", "MEAN_READINGS", "GRIP_READINGS", "GRIP_LARGEST",
    "GRIP_LOADED", "GRIP_WINDOW_S", "GRIP_NOISE", "PULL_WEIGHT", "PULL_SHARE", "VIBRATES_FASTER",
    "CALM_LEAD",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Change:
    """A constant at another value."""

    name: str
    value: float


def known() -> dict[str, float]:
    """Return every constant by its name."""
    return {
        name: float(value) for name, value in vars(constants).items() if isinstance(value, Constant)
    }


def half_and_twice(name: str, value: float) -> tuple[Change, Change]:
    """Return a constant at half and at twice its value, or what stands for these."""
    if name in LOG_ODDS:
        return Change(name, value - math.log(2.0)), Change(name, value + math.log(2.0))
    more = 2.0 * value
    if name in SHARES or name in OF_FRAMES:
        more = 0.5 * (value + (0.5 if name in OF_FRAMES else 1.0))
    return Change(name, 0.5 * value), Change(name, more)
