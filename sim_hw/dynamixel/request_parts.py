"""A sync or bulk request, taken apart into what each servo is asked.

Source: ROBOTIS e-manual, "Protocol 2.0".
"""

from collections.abc import Iterator

from drivers.dynamixel.frames import Frame, Instruction


def number_of(data: bytes) -> int:
    """Return the number in the first two bytes."""
    return int.from_bytes(data[:2], "little")


def reads_of(frame: Frame) -> Iterator[tuple[int, int, int]]:
    """Id, address and length of every part of a sync or bulk read."""
    data = frame.parameters
    if frame.instruction == Instruction.SYNC_READ:
        address, length = number_of(data), number_of(data[2:])
        for servo_id in data[4:]:
            yield servo_id, address, length
    else:
        for at in range(0, len(data) - 4, 5):
            yield data[at], number_of(data[at + 1 :]), number_of(data[at + 3 :])


def writes_of(frame: Frame) -> Iterator[tuple[int, int, bytes]]:
    """Id, address and data of every part of a sync or bulk write; what is cut short is left out."""
    data = frame.parameters
    if frame.instruction == Instruction.SYNC_WRITE:
        address, length = number_of(data), number_of(data[2:])
        for at in range(4, len(data) - length, length + 1):
            yield data[at], address, data[at + 1 : at + 1 + length]
        return
    at = 0
    while at + 5 <= len(data):
        address, length = number_of(data[at + 1 :]), number_of(data[at + 3 :])
        if at + 5 + length <= len(data):
            yield data[at], address, data[at + 5 : at + 5 + length]
        at += 5 + length
