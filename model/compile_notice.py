"""Listeners for the making of machine code, which takes seconds on the first run after a change.

Light, so that a command can listen before anything heavy is imported.
"""

from collections.abc import Callable

# Called with True when a function's compilation begins and with False when it ends; they nest.
Listener = Callable[[bool], None]
_listeners: list[Listener] = []


def on_compiling(listener: Listener) -> None:
    """Notify a listener from now on; the same one only once."""
    if listener not in _listeners:
        _listeners.append(listener)


def notify(*, begins: bool) -> None:
    """Notify all listeners."""
    for listener in _listeners:
        listener(begins)
