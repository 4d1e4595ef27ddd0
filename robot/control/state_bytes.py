"""The controller's state as bytes, and back: equal states give equal bytes.

A gait goes by its name. Whoever makes the state again has the controller, and with it the gait.
"""

from collections.abc import Mapping
from functools import cache

from gaits.gait import Gait
from record.exact_values import Classes, classes_in, decode_values, encode_values
from robot.control.estimator_stage import StageMemory
from robot.control.state import ControllerState


@cache
def _classes() -> Classes:
    return classes_in(ControllerState)


def _name_of(value: object) -> str | None:
    """The name of a gait, None of all else."""
    if callable(getattr(value, "stance", None)):
        name: str = value.name  # type: ignore[attr-defined]
        return name
    return None


def bytes_of_state(state: ControllerState) -> bytes:
    """Return all that the controller remembers."""
    return encode_values(state, _name_of)


def state_of_bytes(data: bytes, gaits: Mapping[str, Gait]) -> ControllerState:
    """Return the state of which these are the bytes.

    Args:
        data: Of ``bytes_of_state``.
        gaits: The controller's, by name.

    Raises:
        ValueError: They are not bytes of this version, or there is no such gait.
    """
    state = decode_values(data, _classes(), gaits.__getitem__)
    if not isinstance(state, ControllerState):
        raise ValueError(f"a state is expected, not {type(state).__name__}")
    return state


def estimator_of_bytes(data: bytes) -> StageMemory | None:
    """Return what the estimator remembered, None where it was off.

    Args:
        data: Of ``bytes_of_state``.

    Raises:
        ValueError: They are not bytes of this version.
    """
    state = decode_values(data, _classes(), _no_gait)
    if not isinstance(state, ControllerState):
        raise ValueError(f"a state is expected, not {type(state).__name__}")
    return state.estimates.estimator


def bytes_of_estimator(memory: StageMemory) -> bytes:
    """Return all that the estimator remembers."""
    return encode_values(memory)


def _no_gait(_name: str) -> None:
    """No estimate depends on the gait."""
