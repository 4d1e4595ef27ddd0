"""What scripts of a page read: JSON, and in it arrays as base64 of little-endian numbers."""

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from model.values.arrays import FloatArray

UNKNOWN, UNKNOWN_WHOLE = 1e30, -32768


def script_json(content: object) -> str:
    """Return JSON that may stand in a script element: nothing in it ends the element.

    Raises:
        ValueError: It holds NaN or an infinite number.
    """
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")


def packed_floats(values: FloatArray) -> str:
    """Return numbers of any shape, row by row, with 1e30 for what is not known."""
    return packed_text(np.where(np.isfinite(values), values, UNKNOWN), np.float32)


def packed_whole(values: FloatArray) -> dict[str, object]:
    """Return numbers to 1/32767 of the largest, with -32768 for what is not known, and their scale."""
    most = float(np.nanmax(np.abs(values), initial=1e-9)) if np.isfinite(values).any() else 1.0
    scale = most / 32767.0
    whole = np.where(np.isfinite(values), np.round(np.nan_to_num(values) / scale), UNKNOWN_WHOLE)
    return {"scale": scale, "data": packed_text(whole, np.int16)}


def packed_text(values: np.ndarray[Any, Any], kind: DTypeLike) -> str:
    """Return numbers of a kind, row by row."""
    little = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<"))
    return base64.b64encode(little.tobytes()).decode("ascii")
