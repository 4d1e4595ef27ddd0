"""One servo by register name: what it does not give or take raises an error naming leg and id."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.frames import Instruction
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.registers import RegisterTable
from drivers.dynamixel.requests import ServoRequests
from model.errors import BusError

# A servo that misses so many requests in a row is not there; one lost on the way is nothing.
TRIES = 5
# A value that is not kept is written again: an EEPROM cell bears few writes, so not often.
WRITE_TRIES = 3
CLEAR_MULTI_TURN = bytes.fromhex("01 44 58 4C 22")


@dataclass(frozen=True, slots=True)
class CheckedServo:
    """Reads and writes of one servo that raise a ``BusError`` when they fail.

    Attributes:
        packets: How to ask, over an open port.
        leg: Leg name, for the error.
        servo_id: Dynamixel id.
        table: Its registers; without its model those that all models have.
    """

    packets: ServoRequests
    leg: str
    servo_id: int
    table: RegisterTable = COMMON

    @property
    def port(self) -> ClockedPort:
        """The port."""
        return self.packets.port

    @property
    def who(self) -> str:
        """Leg and id, for a person."""
        return f"{self.leg} (id {self.servo_id})"

    def error(self, what: str, register: str = "", code: int | None = None) -> BusError:
        """Return an error about this servo.

        Args:
            what: What is wrong with it and what to do, after its name.
            register: Register concerned, if one is.
            code: Result code, if there is one.
        """
        ids = (self.servo_id,)
        return BusError(
            f"{self.who} {what}", port=self.port.name, ids=ids, register=register, code=code
        )

    def read(self, name: str) -> int:
        """Return a register's value; asks again if an answer is lost on the way.

        Raises:
            BusError: No sound answer.
        """
        register = self.table[name]
        answer = self._read_bytes(register.address, register.size)
        if answer.data is None:
            raise self._refused(f"did not give its {name}", answer, name)
        return register.decode(answer.data)

    def answers_reads(self) -> bool:
        """Return whether it answers a read at all, if only with an error."""
        answer = self._read_bytes(self.table["hardware_error_status"].address, 1)
        return answer.data is not None or answer.error != 0

    def read_run(self, first: str, last: str) -> dict[str, int]:
        """Return the values of all registers from one to another, in one request.

        Only for neighbours: what a read across a gap of the table returns is not documented.

        Raises:
            BusError: No sound answer.
        """
        registers = self.table.between(first, last)
        start = registers[0].address
        answer = self._read_bytes(start, registers[-1].end - start)
        data = answer.data
        if data is None:
            raise self._refused(f"did not give {first} to {last}", answer, first)
        return {r.name: r.decode(data[r.address - start :][: r.size]) for r in registers}

    def _read_bytes(self, address: int, length: int) -> ServoAnswer:
        for _ in range(TRIES):  # again if the answer is lost or damaged, not if the servo refuses
            if length == 1:
                answer = self.packets.read_byte(self.servo_id, address)
            else:
                answer = self.packets.read(self.servo_id, address, length)
            if answer.data is not None or answer.refused:
                break
        return answer

    def write(self, name: str, value: int) -> None:
        """Write a register; again if the answer is lost on the way.

        Raises:
            BusError: The servo did not say that it took the value.
        """
        register = self.table[name]
        data = register.encode(value)
        answer = _until_heard(lambda: self.packets.write(self.servo_id, register.address, data))
        if not answer.ok:
            raise self._refused(f"did not take {name} = {value}", answer, name)

    def write_verified(self, name: str, value: int) -> None:
        """Write a register and read it back, again if it differs: a late word may be that of another write.

        Raises:
            BusError: The servo did not take or not keep the value.
        """
        for _ in range(WRITE_TRIES):
            self.write(name, value)
            kept = self.read(name)
            if kept == value:
                return
        what = f"took {name} = {value} and has {kept}: switch its power off and on"
        raise self.error(what, name)

    def ensure(self, name: str, value: int) -> None:
        """Write only what differs: an EEPROM cell bears a limited number of writes."""
        if self.read(name) != value:
            self.write_verified(name, value)

    def answer_everything(self) -> None:
        """Set the status return level to 2; a servo at level 1 does not even answer that write.

        Raises:
            BusError: It is not at level 2 afterwards.
        """
        level = self.table["status_return_level"]
        if self.read(level.name) != 2:
            # waits for the answer that may come: another request over it would destroy both
            self.packets.write(self.servo_id, level.address, level.encode(2))
            self.write_verified(level.name, 2)

    def clear_turns(self) -> None:
        """Set the turn counter back into one turn; the servo must stand still.

        Raises:
            BusError: It moves, or its firmware (before 42) cannot.
        """
        answer = _until_heard(  # twice does no harm
            lambda: self.packets.ask(self.servo_id, Instruction.CLEAR, CLEAR_MULTI_TURN)
        )
        if not answer.ok:
            raise self._refused("did not set its turn counter back", answer, "present_position")

    def reboot(self) -> bool:
        """Tell the servo to restart; it is deaf for a moment then, and its torque is off.

        Returns:
            Whether it said that it will; False if no answer came.

        Raises:
            BusError: It said that it will not.
        """
        answer = self.packets.ask(self.servo_id, Instruction.REBOOT)
        if answer.refused:
            raise self._refused("did not reboot", answer, "hardware_error_status")
        return answer.ok

    def answers(self) -> bool:
        """Return whether it answers a ping."""
        return self.packets.ask(self.servo_id, Instruction.PING).data is not None

    def _refused(self, what: str, answer: ServoAnswer, register: str) -> BusError:
        return self.error(f"{what}: {answer.words}", register, answer.code)


def _until_heard(ask: Callable[[], ServoAnswer]) -> ServoAnswer:
    """Ask until the servo does it or refuses it, a few times."""
    for _ in range(TRIES):
        answer = ask()
        if answer.ok or answer.refused:
            break
    return answer
