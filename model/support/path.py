"""The search for the contacts, step by step, for pictures of it (fig:robot_2d, fig:search_3d).

The same descent as in ``model.support.kernel``, but in the paper's steps: from the present pose towards
the balance of the feet now in contact, stopping at the *first* plane on which a foot comes down or
lifts, switching that foot and solving again. Slower, and every stop is kept.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly

BALANCE_TOLERANCE = 1e-11  # imbalance accepted, as a share of the weight
RANK_TOLERANCE = 1e-12
PARALLEL = 1e-12  # changes of height below this share of the direction are rounding
STEPS_PER_FOOT = 20
NO_FOOT = -1


@dataclass(frozen=True, slots=True, eq=False)
class SupportPath:
    """The stops of one search, P of them, for N feet.

    Attributes:
        pose: slope_x, slope_y, height [m] at each stop, (P, 3); the first is level, the last the answer.
        target: Balance of the feet in contact there, towards which the search goes, (P, 3); NaN where
            these feet leave the body free to tilt and it tilts as the weight pulls.
        contact: Feet in contact on leaving the stop, (P, N).
        switched: The foot that came down or lifted at the stop, (P,); -1 at the first and last.
    """

    pose: FloatArray
    target: FloatArray
    contact: BoolArray
    switched: IntArray


def search_path(feet_B: FloatArray, stiffness: FloatArray, load: float) -> SupportPath:  # noqa: N803
    """Walk the search and keep every stop.

    Args:
        feet_B: Unloaded feet in the body frame, (N, 3) [m].
        stiffness: Spring constant of each leg, (N,) [N/m].
        load: Weight [N].

    Raises:
        ModelError: There is no equilibrium to walk to: the robot tips.
    """
    rows = np.column_stack([-feet_B[:, 0], feet_B[:, 1], np.ones(len(feet_B))])  # eqn:zpj
    weight = np.array([0.0, 0.0, load])
    pose = np.array([0.0, 0.0, _level_height(feet_B[:, 2], stiffness, load)])
    contact = rows @ pose + feet_B[:, 2] < 0
    # slopes are compared with the height through the largest lever
    lever = max(float(np.abs(feet_B[:, :2]).max()), 1e-9)
    scale = np.array([1 / lever, 1 / lever, 1.0])
    poses, targets, contacts, switched = [pose], [], [], [NO_FOOT]
    for _ in range(STEPS_PER_FOOT * len(feet_B)):
        heights = rows @ pose + feet_B[:, 2]
        down, pressed = rows[contact], stiffness[contact]
        imbalance = down.T @ (pressed * heights[contact]) + weight
        if np.abs(scale * imbalance).max() <= BALANCE_TOLERANCE * load:
            break
        hessian = (down.T * pressed) @ down
        step, free = _step(hessian, imbalance, scale)
        share, foot = _first_switch(heights, rows @ step, contact, endless=free)
        if not np.isfinite(share):
            raise ModelError("the centre of mass is not above the feet: the robot tips")
        targets.append(np.full(3, np.nan) if free else pose + step)
        contacts.append(contact)
        pose = pose + share * step
        poses.append(pose)
        switched.append(foot)
        if foot == NO_FOOT:
            break
        contact = contact.copy()
        contact[foot] = not contact[foot]
    else:
        raise ModelError("the search did not end")
    targets.append(pose)
    contacts.append(contact)
    return SupportPath(
        pose=readonly(np.array(poses)),
        target=readonly(np.array(targets)),
        contact=readonly(np.array(contacts)),
        switched=readonly(np.array(switched, dtype=np.int64)),
    )


def _level_height(foot_height: FloatArray, stiffness: FloatArray, load: float) -> float:
    """Height at which the level body is carried: feet come down lowest first (erratum E6)."""
    order = np.argsort(foot_height)
    heights, springs = foot_height[order], stiffness[order]
    for count in range(1, len(order) + 1):
        k = springs[:count]
        height = -(load + k @ heights[:count]) / k.sum()
        if count == len(order) or heights[count] + height >= 0:
            break
    return float(height)


def _step(hessian: FloatArray, imbalance: FloatArray, scale: FloatArray) -> tuple[FloatArray, bool]:
    """Step to the balance of the feet in contact, or the tilt they leave free (True then)."""
    values, vectors = np.linalg.eigh(hessian * scale[:, None] * scale)
    along = vectors.T @ (scale * imbalance)
    loose = values <= RANK_TOLERANCE * values[-1]
    if loose.any() and np.abs(along[loose]).max() > BALANCE_TOLERANCE * np.abs(along).max():
        return -scale * (vectors[:, loose] @ along[loose]), True
    solved = np.where(loose, 0.0, along / np.where(loose, 1.0, values))
    return -scale * (vectors @ solved), False


def _first_switch(
    heights: FloatArray, change: FloatArray, contact: BoolArray, *, endless: bool
) -> tuple[float, int]:
    """Share of the step up to the first foot that comes down or lifts; the foot, or -1 if none."""
    largest = max(float(np.abs(change).max()), np.finfo(float).tiny)
    towards = np.where(contact, change, -change) > PARALLEL * largest
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(towards, np.maximum(-heights / change, 0.0), np.inf)
    foot = int(np.argmin(share))
    if share[foot] < 1.0 or (endless and np.isfinite(share[foot])):
        return float(share[foot]), foot
    return (np.inf if endless else 1.0), NO_FOOT
