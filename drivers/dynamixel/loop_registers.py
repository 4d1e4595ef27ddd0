"""What the loop reads of every servo at once: where it lies, and from the bytes of all answers to columns.

Six numbers are taken from bytes sooner one by one than as arrays. Everything here is pure.
"""

from collections.abc import Sequence
from itertools import chain
from struct import Struct

import numpy as np

from drivers.dynamixel.catalog import COMMON, CURRENT_OR_LOAD, READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.registers import Register
from model.values.arrays import IntArray, readonly

# By address, as they are read.
LOOP_REGISTERS = (
    COMMON["present_pwm"],
    CURRENT_OR_LOAD,
    COMMON["present_velocity"],
    COMMON["present_position"],
    COMMON["present_input_voltage"],
    COMMON["present_temperature"],
)
LETTERS = {1: "B", 2: "H", 4: "I"}  # ``struct``'s, of so many bytes
NOTHING_READ = bytes(READ_LENGTH)


def _layout(registers: Sequence[Register]) -> Struct:
    """Return the registers with the gaps between them."""
    codes, at = ["<"], READ_ADDRESS
    for one in registers:
        letter = LETTERS[one.size]
        codes.append(f"{one.address - at}x{letter.lower() if one.signed else letter}")
        at = one.end
    return Struct("".join(codes))


_LAYOUT = _layout(LOOP_REGISTERS)


def loop_columns(answers: Sequence[ServoAnswer]) -> IntArray:
    """Return ``LOOP_REGISTERS`` of every answer, 0 where there is none, a row a register, (6, N) int64."""
    read = b"".join([NOTHING_READ if data is None else data for data, _, _ in answers])
    numbers = chain.from_iterable(zip(*_LAYOUT.iter_unpack(read), strict=True))
    columns = np.fromiter(numbers, np.int64, len(LOOP_REGISTERS) * len(answers))
    table: IntArray = readonly(columns.reshape(len(LOOP_REGISTERS), len(answers)))
    return table
