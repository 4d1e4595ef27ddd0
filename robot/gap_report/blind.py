"""What runs cannot show to a diagnosis, said before it begins: which sensors are missing, what hides."""

from collections import defaultdict
from collections.abc import Sequence

from gap.diagnosis.coverage import BlindSpots

JOINT_ANGLES, FOOT_MARKERS = "joint angles", "foot markers"
FORCE_SENSORS, POSE = "force sensors", "the body's pose"
SENSORS = (
    ("shaft", JOINT_ANGLES),
    ("foot", FOOT_MARKERS),
    (("force", "total", "grip"), FORCE_SENSORS),  # totals and grip are read from the forces
    (("body", "mean", "roll", "pitch"), POSE),
)
VERTICAL = "force_z"  # where it alone is measured, what is missing are the other forces
OF_BOTH = "total_moment"  # of forces at markers: if one of these is missing, it is named itself


def blind_lines(spots: BlindSpots) -> list[str]:
    """Return what is missing and what hides, one sentence a line; nothing where all can be seen."""
    groups: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for one in spots.effects:
        if one.channels:
            groups[sensors_of(one.channels, spots.missing)].append(one.effect)
    if not groups:
        return []
    missing = ", ".join(sensors_of(spots.missing, spots.missing))
    lines = [f"not measured: {missing}; these runs cannot show, whatever is wrong"]
    for sensors, effects in groups.items():
        lines.append(f"  {', '.join(effects)} (to be seen with {' or '.join(sensors)})")
    return lines


def blind_json(spots: BlindSpots) -> dict[str, object]:
    """Return the same for ``--json``."""
    return {
        "not_measured": spots.missing,
        "cannot_be_seen": [
            {"effect": one.effect, "sensors": sensors_of(one.channels, spots.missing)}
            for one in spots.effects
            if one.channels
        ],
        # at the size that one expects, by any sensor: the runs do not reach or excite them
        "not_excited": [one.effect for one in spots.effects if not one.channels],
    }


def sensors_of(channels: Sequence[str], missing: Sequence[str]) -> tuple[str, ...]:
    """Return the sensors that channels come from, in a few words, each once.

    Args:
        channels: Names of channels that are missing.
        missing: Names of all that are.
    """
    forces = FORCE_SENSORS if VERTICAL in missing else "horizontal foot forces"
    sensors = (sensor_of(name) for name in channels if not name.startswith(OF_BOTH))
    return tuple(dict.fromkeys(forces if one == FORCE_SENSORS else one for one in sensors))


def sensor_of(channel: str) -> str:
    """Return the sensor that a channel comes from, or its own name."""
    return next((words for starts, words in SENSORS if channel.startswith(starts)), channel)
