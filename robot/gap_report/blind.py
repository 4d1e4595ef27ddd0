"""What runs cannot show to a diagnosis, said before it begins: which sensors are missing, what hides."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from gap.coverage.blind_spots import COMMANDS, BlindSpot, BlindSpots
from model.errors import GapError
from record.trial.trial import Trial

JOINT_ANGLES, FOOT_MARKERS = "joint angles", "foot markers"
FORCE_SENSORS, POSE = "force sensors", "the body's pose"
SENSORS = (
    ("shaft", JOINT_ANGLES),
    ("foot", FOOT_MARKERS),
    (("force", "pull", "total", "grip"), FORCE_SENSORS),  # the others are read from the forces
    (("body", "mean", "roll", "pitch"), POSE),
    (COMMANDS, "commands"),
)
VERTICAL = "force_z"  # where it alone is measured, what is missing are the other forces
# Of all forces, and the moment of markers as well: if one of these is missing, it is named itself.
OF_SEVERAL = "total"


def check_comparable(spots: BlindSpots, trials: Sequence[Trial]) -> None:
    """Refuse runs in which there is nothing to diagnose, and say what is missing.

    Raises:
        GapError: Nothing was measured that the simulator predicts, or nothing says how the joints move.
    """
    driven = any(
        np.isfinite(part).any() for one in trials for part in (one.command_rad, one.shaft_rad)
    )
    still = bool(trials[0].joints) and not driven
    if spots.comparable and not still:
        return
    missing = missing_words(spots)
    if still:
        missing = f"commands, {missing}" if missing else "commands"
        why = (
            "without commands or joint angles (command_J_rad, shaft_J_rad) no run can be simulated"
        )
    else:
        why = "the simulator predicts nothing that was measured"
    raise GapError(
        f"there is nothing to diagnose: {why}; not measured: {missing} (see docs/gap.md#fewer-sensors)"
    )


def blind_lines(spots: BlindSpots) -> list[str]:
    """Return what is missing and what hides, one sentence a line; nothing where all can be seen."""
    missing = missing_words(spots)
    if not spots.effects:
        every = "every effect of the catalogue shows in what was measured"
        return [f"not measured: {missing}; {every}"] if missing else []
    cannot = "these runs cannot show, whatever is wrong"
    lines = [f"not measured: {missing}; {cannot}" if missing else cannot]
    groups: defaultdict[tuple[tuple[str, ...], tuple[str, ...]], list[str]] = defaultdict(list)
    for one in spots.effects:
        groups[one.joints, _sensors(one, spots)].append(one.effect)
    # first what sensors would show, then what hides at some joints only, then what nothing would show
    for (joints, sensors), effects in sorted(
        groups.items(), key=lambda of: (not of[0][1], of[0][0])
    ):
        at = f"at {', '.join(joints)}: " if joints else ""
        how = f"to be seen with {' or '.join(sensors)}" if sensors else "not excited by these runs"
        lines.append(f"  {at}{', '.join(effects)} ({how})")
    return lines


def blind_json(spots: BlindSpots) -> dict[str, object]:
    """Return the same for ``--json``."""
    return {
        "not_measured": spots.missing,
        "not_measured_at": spots.at_joints,
        "cannot_be_seen": [
            {"effect": one.effect, "sensors": _sensors(one, spots)}
            for one in spots.effects
            if one.channels and not one.joints
        ],
        "cannot_be_seen_at": [
            {"effect": one.effect, "joints": one.joints, "sensors": _sensors(one, spots)}
            for one in spots.effects
            if one.joints
        ],
        # at the size that one expects, by any sensor: the runs do not reach or excite them
        "not_excited": [one.effect for one in spots.effects if not one.channels],
    }


def missing_words(spots: BlindSpots) -> str:
    """Name the sensors that are missing, and the joints of those that are missing at some only."""
    some: defaultdict[str, list[str]] = defaultdict(list)
    for one in spots.at_joints:
        for sensor in sensors_of(one.channels, one.channels):
            some[sensor] += one.joints
    everywhere = sensors_of(spots.missing, spots.missing)
    return ", ".join(
        (*everywhere, *(f"{sensor} of {', '.join(joints)}" for sensor, joints in some.items()))
    )


def _sensors(one: BlindSpot, spots: BlindSpots) -> tuple[str, ...]:
    """The sensors that would show an effect."""
    at = [name for some in spots.at_joints for name in some.channels]
    missing = [*spots.missing, *at]
    sensors = sensors_of(one.channels, missing)
    # what only totals show needs the forces that they lack
    return sensors or (sensors_of(at, missing) if one.channels else ())


def sensors_of(channels: Sequence[str], missing: Sequence[str]) -> tuple[str, ...]:
    """Return the sensors that channels come from, in a few words, each once.

    Args:
        channels: Names of channels that are missing, or ``command``.
        missing: Names of all that are.
    """
    forces = FORCE_SENSORS if VERTICAL in missing else "horizontal foot forces"
    sensors = (sensor_of(name) for name in channels if not name.startswith(OF_SEVERAL))
    return tuple(dict.fromkeys(forces if one == FORCE_SENSORS else one for one in sensors))


def sensor_of(channel: str) -> str:
    """Return the sensor that a channel comes from, or its own name."""
    return next((words for starts, words in SENSORS if channel.startswith(starts)), channel)
