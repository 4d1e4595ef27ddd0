"""Raw bytes of both devices as messages of a log: written on request, so that drivers can be replayed."""

from model.values.wire import Wire, WireBytes
from record.log.cdr import CdrReader, CdrWriter

WIRE_TYPE = "bigant_msgs/msg/WireBytes"
WIRE_DEFINITION = (
    "uint8 SERVO_BUS=0\nuint8 FORCE_DATAGRAMS=1\nuint8 FORCE_CONSOLE=2\n"
    "int64 t_ns\nuint8 wire\nbool sent\nuint8[] data\n"
)
BUS_TOPIC = "/bigant/bus"
FORCE_UNIT_TOPIC = "/bigant/force_unit"
WIRE_TOPICS = (BUS_TOPIC, FORCE_UNIT_TOPIC)


def wire_topic(wire: Wire) -> str:
    """Return the topic that a wire's bytes go to."""
    return BUS_TOPIC if wire is Wire.SERVO_BUS else FORCE_UNIT_TOPIC


def encode_wire(piece: WireBytes) -> bytes:
    """Return one piece of traffic as a message."""
    w = CdrWriter()
    w.record("qB?", piece.t_ns, piece.wire.value, piece.sent)
    w.octets(piece.data)
    return w.done()


def decode_wire(data: bytes) -> WireBytes:
    """Return the traffic in a message.

    Raises:
        ValueError: The message is damaged.
    """
    r = CdrReader(data)
    t_ns, wire, sent = r.record("qB?")
    return WireBytes(t_ns, Wire(wire), sent, r.octets())
