"""Where among the joints the gap lies: each joint's part of it, the largest first."""

from dataclasses import dataclass, replace

import numpy as np

from gap.residuals.evidence import Evidence, errors
from gap.residuals.part_error import rms
from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class JointGap:
    """One joint.

    Attributes:
        share: Its energy above expectation over that of all joints, fed what was measured, 0 to 1. Where no
            references say what is expected, a part of each joint's own misfit is, and all joints would have
            equal shares: then its squares in ``channel`` over those of all joints that show a gap.
        channel: The channel in which the joints differ most; for one that has no such channel (a leg, whose
            forces are measured and not its angle) that of its own in which it differs most.
        rms: Measured minus predicted of that channel, in its unit: end to end, or fed what was measured
            where runs have no commands; NaN if not compared.
    """

    joint: str
    share: float
    channel: str
    rms: float
    unit: str


def rank_joints(local: Evidence, end_to_end: Evidence, above: FloatArray) -> tuple[JointGap, ...]:
    """Rank the joints that have channels.

    Args:
        local: The trials, each stage by itself.
        end_to_end: The same under commands, or ``local`` where runs have none.
        above: Energy of each channel above expectation, (C,).
    """
    channels = local.simulator.channels
    joints = tuple(dict.fromkeys(one.joint for one in channels if one.joint))
    if not joints:
        return ()
    of_joint = [one for one in channels if one.joint]
    names = tuple(dict.fromkeys(one.name for one in of_joint))
    energy = {
        name: sum(
            float(a) for a, c in zip(above, channels, strict=True) if c.joint and c.name == name
        )
        for name in names
    }
    shown = max(names, key=lambda name: energy[name])
    total = max(sum(energy.values()), 1e-300)
    raw = rms(np.concatenate(errors(end_to_end.predictor, end_to_end.parts, end_to_end.drive)))
    ranked = []
    for joint in joints:
        own = sum(float(a) for a, c in zip(above, channels, strict=True) if c.joint == joint)
        theirs = [i for i, c in enumerate(channels) if c.joint == joint]
        at = max(theirs, key=lambda i: (channels[i].name == shown, np.isfinite(raw[i]), above[i]))
        c = channels[at]
        ranked.append(JointGap(joint, own / total, c.name, float(raw[at]), c.unit))
    same = all(np.isfinite(one.rms) and one.channel == shown for one in ranked)
    if local.floor.source != "references" and same:
        squares = [one.rms**2 if one.share > 0.0 else 0.0 for one in ranked]
        total = max(sum(squares), 1e-300)
        ranked = [replace(one, share=s / total) for one, s in zip(ranked, squares, strict=True)]
    return tuple(sorted(ranked, key=lambda one: (-one.share, -np.nan_to_num(one.rms))))
