"""The still picture of a replay: the robot amid its walk, for paper and readers without scripts."""

import html
from collections.abc import Sequence
from typing import Any

import numpy as np

from model.values.arrays import FloatArray

WIDTH, HEIGHT, MARGIN = 640.0, 320.0, 24.0
AZIMUTH, ELEVATION = np.radians(-55.0), np.radians(28.0)  # as replay.js begins
EDGES = (
    (0, 1),
    (1, 3),
    (3, 2),
    (2, 0),
    (4, 5),
    (5, 7),
    (7, 6),
    (6, 4),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
)
MEASURED, PREDICTED, PATH = "#0072B2", "#D55E00", "#0072B2"


def still_of(arrays: dict[str, Any], *, named: bool = False) -> str:
    """Return a frame of a replay, seen from the front right and above, as SVG; with names at the feet."""
    known = np.flatnonzero(np.isfinite(arrays["points"]).all(axis=(1, 2)))
    row = int(known[len(known) // 2])
    turn = rotation(arrays["turn"][row])
    place = np.nan_to_num(arrays["place"][row])

    def world(points: FloatArray) -> FloatArray:
        moved: FloatArray = points @ turn.T + place
        return moved

    lines: list[tuple[str, float, FloatArray]] = []
    for path in list(arrays["paths"].values())[:1]:
        ground = np.column_stack([path, np.zeros(len(path))])
        lines.append((PATH, 1.5, ground[np.isfinite(path).all(axis=1)]))
    box = np.array(arrays["box"])
    corners = world(box[:3] + box[3:] * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5))
    lines += [("currentColor", 1.5, corners[list(edge)]) for edge in EDGES]
    points = world(arrays["points"][row])
    for _, begin, count in arrays["strips"]:
        lines.append(("currentColor", 2.5, points[begin : begin + count]))
    for name, colour in (("measured", MEASURED), ("predicted", PREDICTED)):
        for foot, force in zip(arrays["feet"][row], arrays[name][row], strict=True):
            if np.isfinite(force).all():
                ends = np.stack([foot, foot + arrays["metres_per_newton"] * force])
                lines.append((colour, 2.0, world(ends)))
    names = arrays["names"] if named else []
    return _svg(lines, world(arrays["feet"][row]), names)


def rotation(quaternion_xyzw: FloatArray) -> FloatArray:
    """Return the rotation matrix of a quaternion, (3, 3); none where it is not known."""
    x, y, z, w = quaternion_xyzw if np.isfinite(quaternion_xyzw).all() else (0.0, 0.0, 0.0, 1.0)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def _seen(points: FloatArray) -> FloatArray:
    """Places on the paper, (K, 2), not yet scaled: to the right and down."""
    x, y, z = points.T
    right = -np.sin(AZIMUTH) * x + np.cos(AZIMUTH) * y
    away = -np.cos(AZIMUTH) * x - np.sin(AZIMUTH) * y
    return np.column_stack([right, -(np.cos(ELEVATION) * z + np.sin(ELEVATION) * away)])


def _svg(lines: list[tuple[str, float, FloatArray]], feet: FloatArray, names: Sequence[str]) -> str:
    seen = [(colour, width, _seen(points)) for colour, width, points in lines if len(points)]
    every = np.concatenate([points for _, _, points in seen])
    low, high = every.min(axis=0), every.max(axis=0)
    room = np.array([WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN])
    scale = float(np.min(room / np.maximum(high - low, 1e-6)))
    shift = np.array([WIDTH, HEIGHT]) / 2 - scale * (low + high) / 2
    drawn = "".join(
        f"<polyline points='{' '.join(f'{x:.1f},{y:.1f}' for x, y in scale * points + shift)}' "
        f"fill='none' stroke='{colour}' stroke-width='{width:g}' stroke-linejoin='round'/>"
        for colour, width, points in seen
    )
    for name, (x, y) in zip(names, scale * _seen(feet) + shift, strict=False):
        drawn += (
            f"<text x='{x:.1f}' y='{y + 13:.1f}' font-size='11' text-anchor='middle'>"
            f"{html.escape(name)}</text>"
        )
    return (
        f"<svg viewBox='0 0 {WIDTH:g} {HEIGHT:g}' xmlns='http://www.w3.org/2000/svg'>{drawn}</svg>"
    )
