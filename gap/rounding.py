"""Numbers as a reader wants them: a value to the first digit of its error, a share without a minus zero."""

import math

# Powers of ten without an exponent: of the error; and of the value, where the error is far smaller still.
FIXED_FROM, FIXED_TO = -4, 6
PLAIN_FROM, MOST_DECIMALS = -3, 7


def value_words(value: float, error: float, unit: str = "") -> str:
    """Write a value with its error, rounded to the first digit of the error.

    Args:
        value: The value.
        error: Its standard error; without one the value has three digits.
        unit: Of both; empty for none.
    """
    behind = f" {unit}" if unit else ""
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return f"{value:.3g}{behind}" if math.isfinite(value) else "-"
    power = math.floor(math.log10(error))
    power = math.floor(math.log10(round(error, -power)))  # 0.0096 is 0.01
    top = max(power, math.floor(math.log10(abs(value))) if value else power)
    plain = top >= PLAIN_FROM and power >= -MOST_DECIMALS
    if power < FIXED_TO and (power >= FIXED_FROM or plain):
        return f"{fixed(value, -power)} +- {fixed(error, -power)}{behind}"
    digits = f"{value:.{top - power}e}" if abs(value) >= 0.5 * 10.0**power else "0"
    return f"{digits} +- {error:.0e}{behind}"


def fixed(value: float, decimals: int) -> str:
    """Write a number with so many decimals; rounded to tens where that is negative, and never as -0."""
    rounded = round(value, decimals) + 0.0
    return f"{rounded:.{max(0, decimals)}f}"


def percent_words(share: float) -> str:
    """Write a share as a percentage; a dash where it is not known."""
    return "-" if math.isnan(share) else f"{round(100 * share) + 0}%"


def count_words(count: int, one: str) -> str:
    """Write how many there are of something: 1 hole, 2 holes."""
    return f"{count} {one}" + ("" if count == 1 else "s")
