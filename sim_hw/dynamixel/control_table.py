"""The memory of one virtual servo: control table with access rules and indirect addressing.

The registers are those of its model. Source of the rules: ROBOTIS e-manual, MX-106(2.0) and "Protocol 2.0".
What a read across reserved gaps returns is not documented and has not been tried on a servo:
``ServoAssumed.reserved`` chooses between zeros (the default) and an Access Error. A write through indirect
data is checked for the value it makes, byte by byte where only a part of a register is mapped; that too is
assumed.
"""

from functools import cache
from struct import Struct
from typing import NamedTuple

import numpy as np

from drivers.dynamixel.frames import StatusError
from drivers.dynamixel.registers import OperatingMode, Register
from drivers.dynamixel.servo_model import ServoModel
from model.values.arrays import FloatArray, IntArray, readonly
from sim_hw.assumed import SERVO_ASSUMED, ServoAssumed

# What a servo measures, first and last; ``struct``'s letters of so many bytes.
FIRST_MEASURED, LAST_MEASURED = "realtime_tick", "present_temperature"
GOAL = "goal_position"  # it changes in every tick of a loop
TRIPPED = -1  # of Bus Watchdog
POSITION = int(OperatingMode.POSITION)
LETTERS = {1: "B", 2: "H", 4: "I"}
# Registers that hold a limit of others; exceeding one is Data Limit, not Data Range.
LIMITED_BY = {
    "goal_pwm": "pwm_limit",
    "goal_current": "current_limit",
    "goal_velocity": "velocity_limit",
}


@cache
def _places(
    model: ServoModel,
) -> tuple[dict[int, Register], dict[int, Register], dict[tuple[int, int], Register]]:
    """Return three ways to a register.

    Returns:
        The register of each byte, the indirect address behind each byte of indirect data, and what a write
        of so many bytes at an address sets, where that is one register.
    """
    table = model.table
    cover = {one.address + i: one for one in table for i in range(one.size)}
    addresses = [one for one in table if one.name.startswith("indirect_address_")]
    data = [table[one.name.replace("address", "data")] for one in addresses]
    pointers = {one.address: to for one, to in zip(data, addresses, strict=True)}
    whole = {(one.address, one.size): one for one in table if one.address not in pointers}
    return cover, pointers, whole


class MeasuredRun(NamedTuple):
    """The registers of what a servo measures: neighbours without a gap.

    Attributes:
        address: Where they begin.
        layout: How they lie there.
        names: Theirs.
        sizes: Bytes of each, (R,).
        bounds: Least and largest value of each, (R, 2).
    """

    address: int
    layout: Struct
    names: frozenset[str]
    sizes: IntArray
    bounds: FloatArray


@cache
def measured_run(model: ServoModel) -> MeasuredRun:
    """Return what a servo measures."""
    registers = model.table.between(FIRST_MEASURED, LAST_MEASURED)
    letters = [LETTERS[one.size].lower() if one.signed else LETTERS[one.size] for one in registers]
    layout = Struct("<" + "".join(letters))
    assert registers[0].address + layout.size == registers[-1].end, "they are neighbours"
    least = [-(1 << 8 * one.size - 1) if one.signed else 0 for one in registers]
    most = [(1 << 8 * one.size - one.signed) - 1 for one in registers]
    return MeasuredRun(
        registers[0].address, layout, frozenset(one.name for one in registers),
        readonly(np.array([one.size for one in registers])),
        readonly(np.array([least, most], dtype=np.float64).T.copy()),
    )  # fmt: skip


class ControlTable:
    """One servo's registers.

    Args:
        model: Its model.
        servo_id: Id.
        baud_code: Value of the baud rate register.
        return_delay: Value of the return delay register.
        assumed: What is assumed about the servo.

    Attributes:
        model: Its model.
        values: By name, as the bytes have them, of all registers but what is measured; only to be read.
        changes: Rises whenever a register changes that is neither measured nor a goal position.
    """

    def __init__(
        self,
        model: ServoModel,
        servo_id: int,
        baud_code: int,
        return_delay: int,
        assumed: ServoAssumed = SERVO_ASSUMED,
    ) -> None:
        self._gaps_are_zeros = assumed.reserved == "zeros"
        self.model = model
        self._registers = model.table.by_name
        self._size = model.table.size
        self._cover, self._pointers, self._whole = _places(model)
        self._memory = bytearray(self._size)
        measured = measured_run(model)
        self._measured_at, self._layout, self._measured = (
            measured.address, measured.layout, measured.names,
        )  # fmt: skip
        self.values: dict[str, int] = {}
        self.changes = 0
        goal = self._registers[GOAL]
        self._goal_at = slice(goal.address, goal.end)
        self._plain_to = min(self._pointers, default=self._size)  # no indirect data before it
        for register in model.table:
            self.set(register.name, register.initial or 0)
        self.set("model_number", model.number)
        self.set("firmware_version", assumed.firmware)
        self.set("id", servo_id)
        self.set("baud_rate", baud_code)
        self.set("return_delay_time", return_delay)

    def __contains__(self, name: str) -> bool:
        """Whether its model has a register of this name."""
        return name in self._registers

    def get(self, name: str) -> int:
        """Return a register's value."""
        value = self.values.get(name)
        return self._decoded(self._registers[name]) if value is None else value

    def _decoded(self, register: Register) -> int:
        return register.decode(bytes(self._memory[register.address : register.end]))

    def set(self, name: str, value: int) -> None:
        """Set a register from inside the firmware; no rule applies."""
        if self.values.get(name) == value:
            return
        register = self._registers[name]
        self._memory[register.address : register.end] = register.encode(value)
        if name not in self._measured:
            self.values[name] = value
            self.changes += name != GOAL

    def put_goal(self, ticks: int, data: bytes) -> None:
        """Set the goal position, given its bytes as well; no rule applies."""
        self._memory[self._goal_at] = data
        self.values[GOAL] = ticks

    def put_measured(self, *values: int) -> None:
        """Set all that is measured, from ``realtime_tick`` on, in the order of the addresses."""
        self._layout.pack_into(self._memory, self._measured_at, *values)

    def may_show_measured(self, address: int, length: int) -> bool:
        """Whether bytes that are read may be of what is measured, by themselves or as indirect data."""
        end, measured = address + length, self._measured_at
        beside = end <= measured or address >= measured + self._layout.size
        return not beside or end > self._plain_to

    def reset_ram(self) -> None:
        """Forget everything that is not kept without power."""
        for register in self._registers.values():
            if not register.eeprom:
                self.set(register.name, register.initial or 0)

    def read(self, address: int, length: int) -> bytes | StatusError:
        """Return bytes as an instruction sees them, indirect data followed to their targets."""
        if length == 0 or address + length > self._size:
            return StatusError.DATA_LENGTH
        addresses = range(address, address + length)
        if addresses.stop <= self._plain_to and self._gaps_are_zeros:
            return bytes(self._memory[address : addresses.stop])
        if not self._gaps_are_zeros and not all(a in self._cover for a in addresses):
            return StatusError.ACCESS
        return bytes(self._memory[self._target(a)] for a in addresses)

    def _target(self, address: int) -> int:
        pointer = self._pointers.get(address)
        return self.get(pointer.name) if pointer is not None else address

    def check_write(self, address: int, data: bytes) -> StatusError:
        """Say what a servo answers to a write, without doing it."""
        if not data or address + len(data) > self._size:
            return StatusError.DATA_LENGTH
        register = self._whole.get((address, len(data)))
        if register is not None:  # as most writes are
            return self._check(register, data)
        position = 0
        while position < len(data):
            register = self._cover.get(address + position)
            if register is None:
                return StatusError.ACCESS
            pointer = self._pointers.get(register.address)
            if pointer is not None:
                error = self._check_byte(self.get(pointer.name), address, data)
                position += 1
            else:
                begins = register.address == address + position
                if not begins or position + register.size > len(data):
                    return StatusError.DATA_LENGTH
                error = self._check(register, data[position : position + register.size])
                position += register.size
            if error is not StatusError.NONE:
                return error
        return StatusError.NONE

    def _check_byte(self, target: int, address: int, data: bytes) -> StatusError:
        """Check the register at ``target`` as a write through indirect data makes it."""
        register = self._cover.get(target)
        if register is None:
            return StatusError.ACCESS
        if register.address in self._pointers:  # a cell that points at itself, as all do at first
            return StatusError.NONE
        made = bytearray(self._memory[register.address : register.end])
        for other, byte in enumerate(data):  # its other bytes may come with the same write
            place = self._target(address + other) - register.address
            if 0 <= place < register.size and address + other in self._pointers:
                made[place] = byte
        return self._check(register, bytes(made))

    def _locked(self, register: Register) -> bool:
        return register.eeprom and self.values["torque_enable"] == 1

    def _check(self, register: Register, data: bytes) -> StatusError:
        if not register.writable or self._locked(register):
            return StatusError.ACCESS
        value, name, values = register.decode(data), register.name, self.values
        limit = LIMITED_BY.get(name)
        if limit is not None and abs(value) > values[limit]:
            return StatusError.DATA_LIMIT
        lowest = 0 if name == "bus_watchdog" else register.minimum
        if not lowest <= value <= register.maximum:
            return StatusError.DATA_RANGE
        if name == "operating_mode" and value not in self.model.modes:
            return StatusError.DATA_RANGE
        if name.startswith("goal_") and values["bus_watchdog"] == TRIPPED:
            return StatusError.DATA_RANGE  # a tripped watchdog takes no goals until it is cleared
        if name == GOAL and values["operating_mode"] == POSITION:
            low, high = values["min_position_limit"], values["max_position_limit"]
            return StatusError.NONE if low <= value <= high else StatusError.DATA_LIMIT
        return StatusError.NONE

    def goal_range(self) -> tuple[int, int]:
        """Return the least and the largest goal position that a write may bring now; (1, 0) for none."""
        values, goal = self.values, self._registers[GOAL]
        if values["bus_watchdog"] == TRIPPED or not goal.writable or self._locked(goal):
            return 1, 0
        if values["operating_mode"] != POSITION:
            return goal.minimum, goal.maximum
        low, high = values["min_position_limit"], values["max_position_limit"]
        return max(low, goal.minimum), min(high, goal.maximum)

    def write(self, address: int, data: bytes) -> list[str]:
        """Do a write that has been checked; return the names of the registers it touched."""
        end = address + len(data)
        register = self._whole.get((address, len(data)))
        if register is not None:
            self._memory[address:end] = data
            self.values[register.name] = register.decode(data)
            self.changes += register.name != GOAL
            return [register.name]
        self.changes += 1
        if end <= self._plain_to:
            self._memory[address:end] = data
            begins = [at for at in range(address, end) if self._cover[at].address == at]
            return [self._renew(at) for at in begins]
        touched: dict[str, None] = {}
        for offset, byte in enumerate(data):
            target = self._target(address + offset)
            self._memory[target] = byte
            touched[self._renew(target)] = None  # at once: it may say where the next byte goes
        return list(touched)

    def _renew(self, target: int) -> str:
        """Take the value of the register at an address from its bytes; return its name."""
        register = self._cover[target]
        self.values[register.name] = self._decoded(register)
        return register.name
