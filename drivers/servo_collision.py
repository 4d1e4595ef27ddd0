"""Two servos with one id: both answer every request, and their answers collide. Only asks."""

from drivers.dynamixel_frames import Instruction
from drivers.mx106 import REGISTER
from drivers.servo_packets import PacketHandler
from drivers.servo_port import ClockedPort

PROBES = 6
# One damaged answer happens on any wire; of colliding ones nearly all are damaged.
DAMAGED_LIMIT = 2


def id_is_shared(port: ClockedPort, packets: PacketHandler, servo_id: int) -> bool:
    """Return whether more than one servo seems to answer to an id.

    What is asked for differs between any two servos (clock, position, current, temperature), so two
    answers at the same time damage each other, and two in a row are one too many.

    Args:
        port: Open port.
        packets: How to ask.
        servo_id: The id; at least one servo answers to it.
    """
    first, last = REGISTER["realtime_tick"], REGISTER["present_temperature"]
    length = last.address + last.size - first.address
    parameters = first.address.to_bytes(2, "little") + length.to_bytes(2, "little")
    damaged = 0
    for _ in range(PROBES):
        before = _oddities(packets)
        answer = packets.request(port, servo_id, Instruction.READ, parameters, length)
        damaged += answer.data is None or _oddities(packets) > before
    return damaged >= DAMAGED_LIMIT


def _oddities(packets: PacketHandler) -> int:
    c = packets.counters
    return c.crc_errors + c.late_replies + c.foreign_replies + c.noise_bytes
