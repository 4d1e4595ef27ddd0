"""The controller's state as a message of a log, now and then: where a replay can begin in the middle."""

from dataclasses import dataclass

from record.log.cdr import CdrReader, CdrWriter

STATE_TYPE = "bigant_msgs/msg/ControllerState"
STATE_DEFINITION = "uint64 index\nuint8[] data\n"
STATE_TOPIC = "/bigant/state"


@dataclass(frozen=True, slots=True)
class LoggedState:
    """What a controller remembered after some ticks.

    Attributes:
        index: Number of the next tick.
        data: The state, as ``record.exact_values`` writes it.
    """

    index: int
    data: bytes


def encode_state(state: LoggedState) -> bytes:
    """Return a state as a message."""
    w = CdrWriter()
    w.record("Q", state.index)
    w.octets(state.data)
    return w.done()


def decode_state(data: bytes) -> LoggedState:
    """Return the state in a message.

    Raises:
        ValueError: The message is damaged.
    """
    r = CdrReader(data)
    (index,) = r.record("Q")
    return LoggedState(index, r.octets())
