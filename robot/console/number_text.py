"""Numbers as a person reads them: a dash for what is not known, and no minus before a zero."""

import math


def number_text(value: float, digits: int, width: int = 0) -> str:
    """Return a number with so many decimals, set to the right of ``width`` letters.

    Args:
        value: The number; NaN and infinity become a dash.
        digits: Decimals.
        width: Letters to fill at least.
    """
    if not math.isfinite(value):
        return f"{'-':>{width}}"
    return f"{round(float(value), digits) + 0.0:{width}.{digits}f}"  # -0.0 + 0.0 is 0.0
