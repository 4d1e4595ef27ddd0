"""Registers of Dynamixel servos with protocol 2.0: one item, a whole table, and what modes and errors are.

Which model has which registers: ``drivers.dynamixel.catalog``. Everything here is pure.
"""

import enum
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType

# What begins here is lost without power, and may be written with torque on.
RAM_FROM = 64


class OperatingMode(enum.IntEnum):
    """Values of register 11."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_BASED_POSITION = 5
    PWM = 16


class HardwareError(enum.IntFlag):
    """Bits of register 70, and of the shutdown mask in register 63."""

    INPUT_VOLTAGE = 0x01
    OVERHEATING = 0x04
    MOTOR_ENCODER = 0x08
    ELECTRICAL_SHOCK = 0x10
    OVERLOAD = 0x20


def hardware_error_names(value: int) -> tuple[str, ...]:
    """Return the names of the bits set, in words; a bit without a name by its mask."""
    masks = [1 << bit for bit in range(8) if value & 1 << bit]
    names = {int(bit): str(bit.name).lower().replace("_", " ") for bit in HardwareError}
    return tuple(names.get(mask, f"bit 0x{mask:02x}") for mask in masks)


@dataclass(frozen=True, slots=True)
class Register:
    """One item of the control table.

    Attributes:
        name: Name in snake case.
        address: First byte.
        size: Bytes.
        writable: Whether it may be written at all.
        eeprom: Whether it is kept without power, and locked while torque is on.
        initial: Factory value, None where it is measured.
        minimum: Smallest value allowed.
        maximum: Largest value allowed.
        signed: Two's complement.
    """

    name: str
    address: int
    size: int
    writable: bool
    eeprom: bool
    initial: int | None
    minimum: int
    maximum: int
    signed: bool

    @property
    def end(self) -> int:
        """The address behind its last byte."""
        return self.address + self.size

    def decode(self, data: bytes) -> int:
        """Return the value of this register's bytes."""
        return int.from_bytes(data, "little", signed=self.signed)

    def encode(self, value: int) -> bytes:
        """Return the bytes of a value.

        Raises:
            OverflowError: The value does not fit into the register's bytes.
        """
        return value.to_bytes(self.size, "little", signed=self.signed)


def _writable(
    name: str, address: int, size: int, initial: int, minimum: int, maximum: int, *, eeprom: bool
) -> Register:
    return Register(name, address, size, True, eeprom, initial, minimum, maximum, minimum < 0)


kept, volatile = partial(_writable, eeprom=True), partial(_writable, eeprom=False)


def read_only(
    name: str, address: int, size: int, *, signed: bool = False, eeprom: bool = False
) -> Register:
    """Return a register that the servo alone writes: what it is, or what it measures."""
    low = -(1 << 8 * size - 1) if signed else 0
    high = (1 << 8 * size - (1 if signed else 0)) - 1
    return Register(name, address, size, False, eeprom, None, low, high, signed)


def indirect(first: int, count: int, address: int, data: int, last: int) -> tuple[Register, ...]:
    """Return a block of indirect addresses and the data behind them.

    Args:
        first: Number of the first one.
        count: How many.
        address: Where the addresses begin.
        data: Where the data begin; at first each points at its own.
        last: Largest address that may be pointed at.
    """
    numbers = range(count)
    return (
        *(
            volatile(f"indirect_address_{first + i}", address + 2 * i, 2, data + i, RAM_FROM, last)
            for i in numbers
        ),
        *(volatile(f"indirect_data_{first + i}", data + i, 1, 0, 0, 255) for i in numbers),
    )


@dataclass(frozen=True, slots=True, eq=False)
class RegisterTable:
    """The registers of one model, or those that several have in common.

    Attributes:
        registers: The registers.
        by_name: The same by name.
    """

    registers: tuple[Register, ...]
    by_name: Mapping[str, Register]

    @staticmethod
    def of(registers: Sequence[Register]) -> "RegisterTable":
        """Return a table of registers."""
        items = tuple(registers)
        return RegisterTable(items, MappingProxyType({one.name: one for one in items}))

    def __getitem__(self, name: str) -> Register:
        """Return a register by its name."""
        return self.by_name[name]

    def __contains__(self, name: str) -> bool:
        """Whether there is a register of this name."""
        return name in self.by_name

    def __iter__(self) -> Iterator[Register]:
        """Go through the registers."""
        return iter(self.registers)

    @property
    def size(self) -> int:
        """The address behind the last register."""
        return max(one.end for one in self.registers)

    def between(self, first: str, last: str) -> list[Register]:
        """Return the registers from one to another, both included, by address."""
        low, high = self.by_name[first].address, self.by_name[last].address
        return [one for one in self.registers if low <= one.address <= high]

    def runs(self, wanted: Callable[[Register], bool]) -> tuple[tuple[str, str], ...]:
        """Return registers as runs of neighbours without a gap: first and last name of each.

        What a read across a gap returns is not documented, so each run is a request of its own.

        Args:
            wanted: Which registers.
        """
        runs: list[tuple[Register, Register]] = []
        for one in sorted(filter(wanted, self.registers), key=lambda r: r.address):
            if runs and runs[-1][1].end == one.address:
                runs[-1] = runs[-1][0], one
            else:
                runs.append((one, one))
        return tuple((first.name, last.name) for first, last in runs)

    @property
    def kept_runs(self) -> tuple[tuple[str, str], ...]:
        """What is kept without power, as runs of neighbours."""
        return self.runs(lambda one: one.eeprom)

    @property
    def kept(self) -> tuple[str, ...]:
        """Names of what is kept without power and may be written."""
        return tuple(one.name for one in self.registers if one.eeprom and one.writable)

    @property
    def gain_runs(self) -> tuple[tuple[str, str], ...]:
        """The gains, as runs of neighbours; they are in RAM."""
        return self.runs(lambda one: one.name.endswith("_gain"))

    @property
    def gains(self) -> tuple[str, ...]:
        """Names of the gains."""
        return tuple(one.name for one in self.registers if one.name.endswith("_gain"))

    def changed(
        self,
        *,
        without: Sequence[str] = (),
        ranges: Mapping[str, tuple[int, int, int]] = MappingProxyType({}),
        more: Sequence[Register] = (),
    ) -> "RegisterTable":
        """Return the table of a model that differs in some registers.

        Args:
            without: Names of those that it does not have.
            ranges: Initial, smallest and largest value of those that have others, by name.
            more: Registers that it has besides.
        """
        items = [one for one in self.registers if one.name not in without]
        for place, one in enumerate(items):
            if one.name in ranges:
                initial, low, high = ranges[one.name]
                items[place] = replace(one, initial=initial, minimum=low, maximum=high)
        return RegisterTable.of(sorted([*items, *more], key=lambda r: r.address))
