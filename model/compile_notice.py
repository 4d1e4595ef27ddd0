"""Who is told while machine code is being made, which takes seconds on the first run after a change.

Light, so that a command can ask to be told before anything heavy is imported.
"""

from collections.abc import Callable

# Called with True when a function's compilation begins and with False when it ends; they nest.
Told = Callable[[bool], None]
_told: list[Told] = []


def tell_of_compiling(told: Told) -> None:
    """Have somebody told from now on; the same one only once."""
    if told not in _told:
        _told.append(told)


def tell(*, begins: bool) -> None:
    """Tell everybody who asked."""
    for told in _told:
        told(begins)
