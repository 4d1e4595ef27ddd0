"""Finding the servos of a robot, and bringing them into the state the loop needs.

Finding only asks. Setting up writes, and only what differs; EEPROM registers change with torque off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from dynamixel_sdk import COMM_SUCCESS

from drivers.dynamixel_frames import Instruction
from drivers.mx106 import (
    MODEL_NUMBER,
    MODEL_NUMBER_PROTOCOL_1,
    REGISTER,
    RETURN_DELAY_UNIT_S,
    TICKS_PER_TURN,
    VOLTAGE_UNIT_V,
    OperatingMode,
    hardware_error_names,
)
from drivers.servo_packets import Answer, PacketHandler
from drivers.servo_port import UNKNOWN_LATENCY_MS, ClockedPort
from drivers.settings import ServoBusSettings
from model.errors import BusError

PING_TRIES = 2
# Firmware before this has no bus watchdog.
FIRST_FIRMWARE_WITH_WATCHDOG = 38
LONGEST_QUIET_RETURN_DELAY = 1
WARN_LATENCY_MS = 4.0
# Beyond this many turns the turn counter is set back before walking: the range ends at 256.
TURNS_TO_CLEAR = 100
CLEAR_MULTI_TURN = bytes.fromhex("01 44 58 4C 22")


@dataclass(frozen=True, slots=True)
class ServoFound:
    """One servo as it introduced itself.

    Attributes:
        leg: Leg name.
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        return_delay: Register 9, in units of 2 us.
        voltage_v: Supply voltage.
    """

    leg: str
    servo_id: int
    model: int
    firmware: int
    return_delay: int
    voltage_v: float


@dataclass(frozen=True, slots=True)
class BusReport:
    """What connecting found out.

    Attributes:
        servos: The servos, in leg order.
        warnings: What should be put right, one sentence each.
    """

    servos: tuple[ServoFound, ...]
    warnings: tuple[str, ...]


def find_servos(port: ClockedPort, packets: PacketHandler, settings: ServoBusSettings) -> BusReport:
    """Ask every servo who it is. Writes nothing.

    Raises:
        BusError: One is missing, of another kind, or in a state that cannot be worked with.
    """
    pairs = [(name, int(i)) for name, i in zip(settings.names, settings.ids, strict=True)]
    pings = {servo_id: _ping(port, packets, servo_id) for _, servo_id in pairs}
    missing = [(name, i) for name, i in pairs if pings[i].data is None]
    if missing:
        raise BusError(
            _missing_words(port.name, settings, missing, len(pairs)),
            port=port.name,
            ids=tuple(i for _, i in missing),
        )
    servos: list[ServoFound] = []
    warnings: list[str] = []
    for name, servo_id in pairs:
        data = pings[servo_id].data or b""
        model, firmware = int.from_bytes(data[:2], "little"), data[2]
        _check_model(port.name, name, servo_id, model)
        servo, remarks = _inspect(port, packets, name, servo_id, model, firmware)
        servos.append(servo)
        warnings += remarks
    return BusReport(tuple(servos), (*_bus_warnings(port, servos), *warnings))


def _ping(port: ClockedPort, packets: PacketHandler, servo_id: int) -> Answer:
    answer = Answer(None, 0, COMM_SUCCESS)
    for _ in range(PING_TRIES):
        answer = packets.ask(port, servo_id, Instruction.PING)
        if answer.data is not None:
            break
    return answer


def _missing_words(
    port_name: str, settings: ServoBusSettings, missing: Sequence[tuple[str, int]], count: int
) -> str:
    if len(missing) == count:
        return (
            f"no servo answers on {port_name} at {settings.baud_rate} baud: check power and cable, "
            f"and whether the baud rate is right with: bigant devices --port {port_name}"
        )
    who = ", ".join(f"{name} (id {i})" for name, i in missing)
    return (
        f"{who} does not answer on {port_name} at {settings.baud_rate} baud, {count - len(missing)} "
        "others do: check its cable and id"
    )


def _check_model(port_name: str, leg: str, servo_id: int, model: int) -> None:
    if model == MODEL_NUMBER:
        return
    what = (
        "has protocol 1.0 firmware: put the MX-106(2.0) firmware on it with Dynamixel Wizard"
        if model == MODEL_NUMBER_PROTOCOL_1
        else f"is model {model}, no MX-106 (2.0): check the ids in the robot file"
    )
    raise BusError(f"{leg} (id {servo_id}) {what}", port=port_name, ids=(servo_id,))


def _inspect(
    port: ClockedPort, packets: PacketHandler, leg: str, servo_id: int, model: int, firmware: int
) -> tuple[ServoFound, list[str]]:
    checked = CheckedServo(port, packets, leg, servo_id)
    errors = hardware_error_names(checked.read("hardware_error_status"))
    if errors:
        raise BusError(
            f"{leg} (id {servo_id}) has shut down ({', '.join(errors)}): remove the cause, then "
            "switch its power off and on",
            port=port.name,
            ids=(servo_id,),
        )
    offset = checked.read("homing_offset")
    if offset != 0:
        raise BusError(
            f"{leg} (id {servo_id}) has a homing offset of {offset}: set it to 0 and put the offset "
            "into servo_zero (with an offset, a tripped watchdog can leave the motor running)",
            port=port.name,
            ids=(servo_id,),
            register="homing_offset",
        )
    remarks = []
    if firmware < FIRST_FIRMWARE_WITH_WATCHDOG:
        remarks.append(f"{leg} has firmware {firmware}, which has no bus watchdog: update it")
    servo = ServoFound(
        leg=leg,
        servo_id=servo_id,
        model=model,
        firmware=firmware,
        return_delay=checked.read("return_delay_time"),
        voltage_v=checked.read("present_input_voltage") * VOLTAGE_UNIT_V,
    )
    return servo, remarks


def _bus_warnings(port: ClockedPort, servos: list[ServoFound]) -> list[str]:
    warnings = []
    slow = [s for s in servos if s.return_delay > LONGEST_QUIET_RETURN_DELAY]
    if slow:
        delay_us = max(s.return_delay for s in slow) * RETURN_DELAY_UNIT_S * 1e6
        who = ", ".join(s.leg for s in slow)
        warnings.append(
            f"{who} wait {delay_us:.0f} us before they answer, once a servo and tick: set their "
            "return delay time to 0 with Dynamixel Wizard"
        )
    if port.latency_ms > WARN_LATENCY_MS and port.latency_ms != UNKNOWN_LATENCY_MS:
        warnings.append(
            f"{port.name} holds answers back for up to {port.latency_ms:.0f} ms: set its "
            "latency_timer to 1"
        )
    return warnings


def configure_servos(port: ClockedPort, packets: PacketHandler, settings: ServoBusSettings) -> None:
    """Torque off, watchdog clear, extended position mode, full status answers, counters near 0.

    Raises:
        BusError: A servo does not take a setting.
    """
    for leg, servo_id in zip(settings.names, (int(i) for i in settings.ids), strict=True):
        setup = CheckedServo(port, packets, leg, servo_id)
        setup.write("status_return_level", 2)
        setup.write("torque_enable", 0)
        setup.write("bus_watchdog", 0)
        setup.ensure("operating_mode", OperatingMode.EXTENDED_POSITION)
        setup.write("profile_velocity", 0)
        setup.write("profile_acceleration", 0)
        if abs(setup.read("present_position")) > TURNS_TO_CLEAR * TICKS_PER_TURN:
            setup.clear_turns()


@dataclass(frozen=True, slots=True)
class CheckedServo:
    """Reads and writes of one servo that raise a ``BusError`` naming leg and register."""

    port: ClockedPort
    packets: PacketHandler
    leg: str
    servo_id: int

    def read(self, name: str) -> int:
        """Return a register's value."""
        register = REGISTER[name]
        answer = self.packets.read(self.port, self.servo_id, register.address, register.size)
        if answer.data is None:
            raise self._refused(f"did not give its {name}", answer, name)
        return register.decode(answer.data)

    def write(self, name: str, value: int) -> None:
        """Write a register."""
        register = REGISTER[name]
        data = register.encode(value)
        answer = self.packets.write(self.port, self.servo_id, register.address, data)
        if not answer.ok and answer.error == 0:  # the wire, not the servo: once more
            answer = self.packets.write(self.port, self.servo_id, register.address, data)
        if not answer.ok:
            raise self._refused(f"did not take {name} = {value}", answer, name)

    def ensure(self, name: str, value: int) -> None:
        """Write only what differs: an EEPROM cell bears a limited number of writes."""
        if self.read(name) != value:
            self.write(name, value)

    def clear_turns(self) -> None:
        """Set the turn counter back into one turn; the servo must stand still."""
        answer = self.packets.ask(self.port, self.servo_id, Instruction.CLEAR, CLEAR_MULTI_TURN)
        if not answer.ok:
            raise self._refused("did not set its turn counter back", answer, "present_position")

    def _refused(self, what: str, answer: Answer, register: str) -> BusError:
        return BusError(
            f"{self.leg} (id {self.servo_id}) {what}: {answer.words}",
            port=self.port.name,
            ids=(self.servo_id,),
            register=register,
            code=answer.code,
        )
