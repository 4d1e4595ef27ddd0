"""How far the centre of mass is from the edge of the polygon of its feet: the static margin.

The margin is the distance from the centre of mass, seen from above, to the nearest edge of the convex hull
of the feet that stand: positive inside, negative outside, where the robot tips (McGhee and Frank 1968, "On
the stability properties of quadruped creeping gaits", doi 10.1016/0025-5564(68)90090-4).
"""

from typing import NamedTuple

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray

# A foot this much of the largest distance beyond a line still lies on it.
ON_THE_LINE = 1e-9


class StaticMargin(NamedTuple):
    """The margin of F frames.

    Attributes:
        margin_m: (F,) [m]; minus infinity where no foot stands.
        nearest_m: From the centre of mass to the nearest place of the polygon's edge, (F, 2) [m].
    """

    margin_m: FloatArray
    nearest_m: FloatArray


class HullEdges(NamedTuple):
    """Edges of the hulls of all frames: the half-planes ``normal . place <= reach`` hold the feet.

    Attributes:
        frame: Frame of each edge, (E,).
        normal: Outward, of length one, (E, 2).
        reach_m: Distance of the origin from its line, positive inside, (E,) [m].
    """

    frame: IntArray
    normal: FloatArray
    reach_m: FloatArray


def static_margin(feet_m: FloatArray, down: BoolArray) -> StaticMargin:
    """Return the static margin about the origin.

    Args:
        feet_m: Feet seen from the centre of mass, (F, N, 2) [m].
        down: Which of them stand, (F, N).
    """
    frames, count, _ = feet_m.shape
    start, along, pair = _pairs(feet_m, down)
    # the nearest place of each chord between two feet; a foot is the chord to itself
    squared = (along**2).sum(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.clip(np.where(squared > 0, -(start * along).sum(-1) / squared, 0.0), 0.0, 1.0)
    place = start + share[..., None] * along
    distance = np.where(pair, np.hypot(place[..., 0], place[..., 1]), np.inf)
    edges = hull_edges(feet_m, down)
    reach = np.full(frames, np.inf)
    np.minimum.at(reach, edges.frame, edges.reach_m)
    inside = (reach > 0) & np.isfinite(reach)
    # inside, the nearest edge; outside, the nearest of all chords, for the hull is made of them
    nearest = np.full((frames, 2), np.nan)
    flat = distance.reshape(frames, count * count)
    best = flat.argmin(axis=1)
    margin = -flat[np.arange(frames), best]
    stands = np.isfinite(margin)
    nearest[stands] = place.reshape(frames, count * count, 2)[np.arange(frames), best][stands]
    order = np.argsort(-edges.reach_m, kind="stable")  # the last one written is the nearest
    frame = edges.frame[order]
    chosen = np.full(frames, -1)
    chosen[frame] = order
    margin[inside] = reach[inside]
    nearest[inside] = (edges.reach_m[:, None] * edges.normal)[chosen[inside]]
    return StaticMargin(margin, nearest)


def hull_edges(feet_m: FloatArray, down: BoolArray) -> HullEdges:
    """Return every edge of every frame's hull; both sides of a hull that is only a line.

    Args:
        feet_m: Feet, (F, N, 2) [m].
        down: Which of them stand, (F, N).
    """
    start, along, pair = _pairs(feet_m, down)
    length = np.hypot(along[..., 0], along[..., 1])
    scale = np.abs(np.where(down[..., None], feet_m, 0.0)).max(initial=1e-300)
    proper = pair & (length > ON_THE_LINE * scale)
    safe = np.where(proper, length, 1.0)
    normal = np.stack([along[..., 1], -along[..., 0]], axis=-1) / safe[..., None]
    reach = (normal * start).sum(-1)
    # all feet of the frame on the inner side of the line
    beyond = np.einsum("fijk,fmk->fijm", normal, np.where(down[..., None], feet_m, np.nan))
    inner = ~(
        beyond > reach[..., None] + ON_THE_LINE * scale
    )  # NaN, a foot in the air, is no hindrance
    edge = proper & inner.all(axis=-1)
    return HullEdges(np.nonzero(edge)[0].astype(np.int64), normal[edge], reach[edge])


def _pairs(feet_m: FloatArray, down: BoolArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """First foot of each pair, the vector to the second, whether both stand: (F, N, N, 2) and (F, N, N)."""
    start = np.broadcast_to(feet_m[:, :, None], (*feet_m.shape[:2], feet_m.shape[1], 2))
    return start, feet_m[:, None] - start, down[:, :, None] & down[:, None]
