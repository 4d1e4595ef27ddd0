"""The errors a person can make us raise.

Three kinds of trouble are never mixed: a *mistake* (wrong file, wrong shape, absent port) raises
one of these before anything moves; a *fault* (late, corrupt, missing, hot) is a value inside the
tick; a *stop* is a mode of the controller with a reason. See ``docs/architecture.md``.
"""

from typing import Any


class BigantError(Exception):
    """Base of every error of ours. Its text is one sentence that says what to do."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between processes by text and attributes: errors are made of other arguments."""
        return _remade, (type(self), self.args, self.__dict__)


def _remade(
    kind: type[BigantError], texts: tuple[object, ...], attributes: dict[str, object]
) -> BigantError:
    """Return an error that has travelled."""
    error = kind.__new__(kind, *texts)
    error.args = texts
    error.__dict__.update(attributes)
    return error


class ConfigError(BigantError):
    """A robot file that cannot be used, or a value that is impossible.

    Args:
        key: Dotted name of the offending key, for example ``leg.crank``.
        reason: What is wrong with it, in words.
        page: Page of docs/ that describes the file that the key is in; empty if that is not known.
    """

    def __init__(self, key: str, reason: str, page: str = "") -> None:
        super().__init__(f"{key}: {reason}")
        self.key = key
        self.reason = reason
        self.page = page


class ModelError(BigantError):
    """A model asked for something that has no meaning: wrong shapes, an impossible linkage."""


class GaitRefused(BigantError):  # noqa: N818 - it is a refusal, and reads as one
    """A gait that the servos cannot follow.

    Args:
        limit: Name of the limit, for example ``servo.max_speed``.
        needed: The largest value the gait asks for.
        allowed: The limit itself.
        unit: Unit of both.
    """

    def __init__(self, limit: str, needed: float, allowed: float, unit: str) -> None:
        super().__init__(
            f"the gait needs {needed:.3g} {unit} but {limit} allows {allowed:.3g} {unit}; "
            "lower the frequency or the sweep"
        )
        self.limit = limit
        self.needed = needed
        self.allowed = allowed


class BusError(BigantError):
    """A servo bus that cannot be opened, found or configured.

    Args:
        message: One sentence that says what to do.
        port: Port name.
        ids: Servo ids concerned.
        register: Register name, if one is concerned.
        code: Result code of the Dynamixel SDK, if there is one.
    """

    def __init__(
        self,
        message: str,
        *,
        port: str = "",
        ids: tuple[int, ...] = (),
        register: str = "",
        code: int | None = None,
    ) -> None:
        super().__init__(message)
        self.port = port
        self.ids = ids
        self.register = register
        self.code = code


class ConnectionLost(BusError):  # noqa: N818
    """The port vanished while in use (unplugged)."""


class ForceStreamError(BigantError):
    """A wireless force-torque unit that cannot be reached or set up."""


class RecordError(BigantError):
    """A log that cannot be written or read."""


class GapError(BigantError):
    """A diagnosis that cannot be made: no usable data, an unknown effect, a cause that does not fit."""
