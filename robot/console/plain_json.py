"""Values as JSON can hold them."""

import math
from pathlib import Path


def plain(value: object) -> object:
    """Return a value for ``json.dumps``, arrays as lists; JSON has no NaN, so what is not known is null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
