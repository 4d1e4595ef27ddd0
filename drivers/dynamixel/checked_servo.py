"""One servo by register name: what it does not give or take raises an error naming leg and id."""

from dataclasses import dataclass

from drivers.dynamixel.frames import Instruction
from drivers.dynamixel.mx106 import REGISTER
from drivers.dynamixel.packets import Answer
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.requests import ServoRequests
from model.errors import BusError

# A servo that misses so many requests in a row is not there; one lost on the way is nothing.
TRIES = 5
CLEAR_MULTI_TURN = bytes.fromhex("01 44 58 4C 22")


@dataclass(frozen=True, slots=True)
class CheckedServo:
    """Reads and writes of one servo that raise a ``BusError`` when they fail.

    Attributes:
        port: Open port.
        packets: How to ask.
        leg: Leg name, for the error.
        servo_id: Dynamixel id.
    """

    port: ClockedPort
    packets: ServoRequests
    leg: str
    servo_id: int

    def read(self, name: str) -> int:
        """Return a register's value; asks again if an answer is lost on the way.

        Raises:
            BusError: No sound answer.
        """
        register = REGISTER[name]
        answer = self._read_bytes(register.address, register.size)
        if answer.data is None:
            raise self._refused(f"did not give its {name}", answer, name)
        return register.decode(answer.data)

    def answers_reads(self) -> bool:
        """Return whether it answers a read at all, if only with an error."""
        register = REGISTER["hardware_error_status"]
        answer = self._read_bytes(register.address, register.size)
        return answer.data is not None or answer.error != 0

    def read_run(self, first: str, last: str) -> bytes:
        """Return the bytes from one register to another; asks again if an answer is lost.

        Only for neighbours: what a read across a gap of the table returns is not documented.

        Raises:
            BusError: No sound answer.
        """
        start, end = REGISTER[first], REGISTER[last]
        length = end.address + end.size - start.address
        answer = self._read_bytes(start.address, length)
        if answer.data is None:
            raise self._refused(f"did not give {first} to {last}", answer, first)
        return answer.data

    def read_first(self, first: str, last: str) -> int:
        """Return the first register of a run; see ``read_run``."""
        register = REGISTER[first]
        return register.decode(self.read_run(first, last)[: register.size])

    def read_last(self, first: str, last: str) -> int:
        """Return the last register of a run; see ``read_run``."""
        register = REGISTER[last]
        return register.decode(self.read_run(first, last)[-register.size :])

    def _read_bytes(self, address: int, length: int) -> Answer:
        for _ in range(TRIES):  # only the wire is given another chance, not a servo's no
            if length == 1:
                answer = self.packets.read_byte(self.port, self.servo_id, address)
            else:
                answer = self.packets.read(self.port, self.servo_id, address, length)
            if answer.data is not None or answer.error:
                break
        return answer

    def write(self, name: str, value: int) -> None:
        """Write a register; again if the answer is lost on the way.

        Raises:
            BusError: The servo did not say that it took the value.
        """
        register = REGISTER[name]
        data = register.encode(value)
        for _ in range(TRIES):
            answer = self.packets.write(self.port, self.servo_id, register.address, data)
            if answer.ok or answer.error:
                break
        if not answer.ok:
            raise self._refused(f"did not take {name} = {value}", answer, name)

    def write_verified(self, name: str, value: int) -> None:
        """Write a register and read it back: a servo may take a value and not keep it.

        Raises:
            BusError: The servo did not take or not keep the value.
        """
        self.write(name, value)
        kept = self.read(name)
        if kept != value:
            raise BusError(
                f"{self.leg} (id {self.servo_id}) took {name} = {value} and has {kept}: switch its "
                "power off and on",
                port=self.port.name,
                ids=(self.servo_id,),
                register=name,
            )

    def ensure(self, name: str, value: int) -> None:
        """Write only what differs: an EEPROM cell bears a limited number of writes."""
        if self.read(name) != value:
            self.write_verified(name, value)

    def answer_everything(self) -> None:
        """Set the status return level to 2; a servo at level 1 does not even answer that write.

        Raises:
            BusError: It is not at level 2 afterwards.
        """
        level = REGISTER["status_return_level"]
        if self.read(level.name) != 2:
            # waits for the answer that may come: another request over it would destroy both
            self.packets.write(self.port, self.servo_id, level.address, level.encode(2))
            self.write_verified(level.name, 2)

    def clear_turns(self) -> None:
        """Set the turn counter back into one turn; the servo must stand still.

        Raises:
            BusError: It moves, or its firmware (before 42) cannot.
        """
        answer = self.packets.ask(self.port, self.servo_id, Instruction.CLEAR, CLEAR_MULTI_TURN)
        if not answer.ok:
            raise self._refused("did not set its turn counter back", answer, "present_position")

    def reboot(self) -> bool:
        """Tell the servo to start anew; it is deaf for a moment then, and its torque is off.

        Returns:
            Whether it said that it will; False if no answer came.

        Raises:
            BusError: It said that it will not.
        """
        answer = self.packets.ask(self.port, self.servo_id, Instruction.REBOOT)
        if answer.error and not answer.ok:
            raise self._refused("did not reboot", answer, "hardware_error_status")
        return answer.ok

    def answers(self) -> bool:
        """Return whether it answers a ping."""
        return self.packets.ask(self.port, self.servo_id, Instruction.PING).data is not None

    def _refused(self, what: str, answer: Answer, register: str) -> BusError:
        return BusError(
            f"{self.leg} (id {self.servo_id}) {what}: {answer.words}",
            port=self.port.name,
            ids=(self.servo_id,),
            register=register,
            code=answer.code,
        )
