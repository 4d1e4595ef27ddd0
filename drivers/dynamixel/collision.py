"""Two servos with one id: both answer every request, and their answers collide. Only asks."""

from drivers.dynamixel.frames import Instruction
from drivers.dynamixel.mx106 import REGISTER
from drivers.dynamixel.packets import PacketHandler

PROBES = 6
# One damaged answer happens on any wire; of colliding ones nearly all are damaged.
DAMAGED_LIMIT = 2


def id_is_shared(packets: PacketHandler, servo_id: int) -> bool:
    """Return whether more than one servo seems to answer to an id.

    What is asked for differs between any two servos (clock, position, current, temperature), so two
    answers at the same time damage each other, and two in a row are one too many.

    Args:
        packets: How to ask, over an open port.
        servo_id: The id; at least one servo answers to it.
    """
    first, last = REGISTER["realtime_tick"], REGISTER["present_temperature"]
    length = last.address + last.size - first.address
    parameters = first.address.to_bytes(2, "little") + length.to_bytes(2, "little")
    damaged, answered = 0, False
    for _ in range(PROBES):
        bad, late = _damage(packets), packets.counters.late_replies
        answer = packets.request(servo_id, Instruction.READ, parameters, length)
        # what this request found waiting came behind a sound answer; behind a timeout it is just late
        second = answered and packets.counters.late_replies > late
        damaged += second or _damage(packets) > bad
        answered = answer.data is not None
        packets.suspect_late = True  # the next request first listens for a second answer
    return damaged >= DAMAGED_LIMIT


def _damage(packets: PacketHandler) -> int:
    counters = packets.counters
    return counters.crc_errors + counters.foreign_replies + counters.noise_bytes
