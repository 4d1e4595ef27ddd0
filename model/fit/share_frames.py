"""Which frames of a log tell about leg stiffness, and which feet of them count as loaded."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.support.load_derivatives import load_derivatives
from model.values.arrays import BoolArray, FloatArray

# A foot that carries more than this share of the weight is in contact.
CONTACT_SHARE = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class ShareFrames:
    """Frames of which the fit of the stiffness makes use.

    Attributes:
        feet: Unloaded feet, (F, N, 3) [m].
        contact: Loaded, as measured or as the model has it, (F, N).
        share: Measured share of the load, (F, N); of meaning in contact only.
        pose: Measured slopes [rad] and height [m], (F, 3), NaN where not known.
        pose_weight: What an error of the pose means as an error of a share, (3,).
        left_out: Why frames were left out, and how many.
    """

    feet: FloatArray
    contact: BoolArray
    share: FloatArray
    pose: FloatArray
    pose_weight: FloatArray
    left_out: tuple[tuple[str, int], ...]


def choose_share_frames(
    feet: FloatArray,
    vertical: FloatArray,
    weight: float,
    start: FloatArray,
    pose: FloatArray | None,
) -> ShareFrames:
    """Leave out what cannot be used, and count it.

    Args:
        feet: Unloaded feet in the body frame, (F, N, 3) [m].
        vertical: Measured vertical forces, (F, N).
        weight: Weight carried, same unit as the forces.
        start: A first guess of the stiffness, (N,).
        pose: Measured pose, (F, 3), or None.

    Raises:
        ModelError: No frame is left.
    """
    everything = np.concatenate([feet.reshape(len(feet), -1), vertical], axis=1)
    present = np.isfinite(everything).all(axis=1)
    solved = load_derivatives(np.where(present[:, None, None], feet, 0.0), start, weight).solved
    stands = np.isfinite(solved.load_n).all(axis=1)
    contact: BoolArray = (vertical > CONTACT_SHARE * weight) | (np.nan_to_num(solved.load_n) > 0)
    total: FloatArray = np.sum(np.where(contact, vertical, 0.0), axis=1)
    used: BoolArray = present & stands & (total > CONTACT_SHARE * weight)
    left_out = (
        ("a foot or a force is missing", int((~present).sum())),
        ("the robot tips", int((present & ~stands).sum())),
        ("no foot is loaded", int((present & stands & ~used).sum())),
    )
    if not used.any():
        raise ModelError(
            "no frame can be used to fit the stiffness: "
            + ", ".join(f"{why} in {count}" for why, count in left_out if count)
        )
    chosen = feet[used]
    lever = float(np.sqrt(np.mean(chosen[..., :2] ** 2)))
    # an error of a height means a load of K times it: the same as a share in the fit
    weights = float(start.mean()) / weight * np.array([lever, lever, 1.0])
    return ShareFrames(
        feet=chosen,
        contact=contact[used],
        share=vertical[used] / total[used, None],
        pose=np.full((len(chosen), 3), np.nan) if pose is None else pose[used],
        pose_weight=weights,
        left_out=tuple((why, count) for why, count in left_out if count),
    )
