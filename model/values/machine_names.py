"""What a machine's parts are called: its joints, and its legs.

A leg with one joint has one name for both. Where a leg has several, each of them has its own.
"""

import re
from typing import NamedTuple

# Names stand in those of columns and topics: no spaces, slashes, quotes.
PART_NAME = re.compile(r"\w[\w.-]*")


class MachineNames(NamedTuple):
    """Names of J joints and of N legs, in the order used everywhere."""

    joints: tuple[str, ...]
    legs: tuple[str, ...]

    @property
    def one_joint_a_leg(self) -> bool:
        """Whether legs are called as their joints."""
        return self.joints == self.legs


def one_joint_a_leg(names: tuple[str, ...]) -> MachineNames:
    """Return the names of a machine whose legs are called as their joints."""
    return MachineNames(names, names)
