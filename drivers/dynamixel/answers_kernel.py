"""The answers of all servos to the loop's read, checked and taken apart in one compiled call.

Only where nothing is out of the way: every servo has answered in its turn, undamaged, without an error or
stuffing. Everything else is left to ``FrameParser``, byte by byte.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.dynamixel.catalog import READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.frames import ALERT, CRC_OF_BYTES, STATUS, STATUS_BYTES, STUFFING_MARK
from drivers.dynamixel.loop_registers import LOOP_REGISTERS
from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.values.arrays import IntArray, readonly

_CRC = np.array(CRC_OF_BYTES, dtype=np.int64)
_HEAD_BYTES = 9  # up to the error byte, with it
_BEHIND_LENGTH = 7  # where the bytes begin that the length counts
_FAILED = 0xFF & ~ALERT


@in_place
@compiled
def answers_kernel(
    data: NDArray[np.uint8], ids: IntArray, length: int, places: IntArray, table: IntArray
) -> bool:
    """Take answers apart that are as they should be.

    Args:
        data: All bytes, N times ``STATUS_BYTES + length``.
        ids: Whom to expect, in this order, (N,).
        length: Bytes of parameters of each.
        places: Of each register: its first byte in the parameters, its bytes, 1 if it has a sign; (R, 3).
        table: Error bytes, and below them the registers, (1 + R, N); written.

    Returns:
        Whether they are; if not, nothing written is to be used.
    """
    size = STATUS_BYTES + length
    for k in range(ids.size):
        at = k * size
        count = int(data[at + 5]) | int(data[at + 6]) << 8
        if data[at] != 0xFF or data[at + 1] != 0xFF or data[at + 2] != 0xFD or data[at + 3] != 0:
            return False
        if data[at + 4] != ids[k] or count != size - _BEHIND_LENGTH or data[at + 7] != STATUS:
            return False
        error = int(data[at + 8])
        if error & _FAILED:
            return False
        crc = 0
        for i in range(at, at + size - 2):
            crc = (crc << 8 ^ _CRC[crc >> 8 ^ int(data[i])]) & 0xFFFF
        if crc != int(data[at + size - 2]) | int(data[at + size - 1]) << 8:
            return False
        table[0, k] = error
        for r in range(places.shape[0]):
            first, number = at + _HEAD_BYTES + places[r, 0], 0
            for i in range(places[r, 1]):
                number |= int(data[first + i]) << 8 * i
            if places[r, 2] == 1 and number >> 8 * places[r, 1] - 1:
                number -= 1 << 8 * places[r, 1]
            table[1 + r, k] = number
    return True


_PLACES = readonly(
    np.array([[r.address - READ_ADDRESS, r.size, int(r.signed)] for r in LOOP_REGISTERS])
)


def loop_reader(ids: Sequence[int]) -> Callable[[bytes], IntArray | None]:
    """Return what reads the answers of these servos; its machine code is loaded or made here.

    Returns:
        From all bytes to error bytes and ``LOOP_REGISTERS``, (7, N) int64; None where anything is missing,
        damaged, stuffed, too much, or an error.
    """
    compile_for(
        answers_kernel, *given(1, kind="uint8"), *given(1, kind=COUNT), COUNT, *given(2, kind=COUNT),
        *out(2, kind=COUNT),
    )  # fmt: skip
    return partial(_read, readonly(np.array(ids, dtype=np.int64)))


def _read(ids: IntArray, data: bytes) -> IntArray | None:
    count = len(ids)
    if len(data) != count * (STATUS_BYTES + READ_LENGTH) or data.count(STUFFING_MARK) != count:
        return None
    table = np.empty((1 + len(_PLACES), count), dtype=np.int64)
    bytes_ = np.frombuffer(data, np.uint8)
    if not answers_kernel(bytes_, ids, READ_LENGTH, _PLACES, table):
        return None
    return readonly(table)
