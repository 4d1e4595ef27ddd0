"""The condition of one servo, for a check before walking. Only asks."""

from dataclasses import dataclass

from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.registers import hardware_error_names
from drivers.dynamixel.units import RETURN_DELAY_UNIT_S, VOLTAGE_UNIT_V

# Neighbours without a gap, of 14, 4, 2, 1 and 3 bytes.
RUNS = (
    ("model_number", "protocol_type"),
    ("homing_offset", "homing_offset"),
    ("shutdown", "torque_enable"),
    ("hardware_error_status", "hardware_error_status"),
    ("present_input_voltage", "present_temperature"),
)


@dataclass(frozen=True, slots=True)
class ServoCondition:
    """What a servo says of itself.

    Attributes:
        leg: Leg name.
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        operating_mode: Register 11.
        return_delay: Register 9, in units of 2 us.
        homing_offset: Register 20 [ticks].
        shutdown: Errors that switch its torque off, bits of ``HardwareError``.
        torque: Whether torque is on.
        hardware_error: Latched errors, bits of ``HardwareError``.
        voltage_v: Supply voltage.
        temperature_c: Temperature.
    """

    leg: str
    servo_id: int
    model: int
    firmware: int
    operating_mode: int
    return_delay: int
    homing_offset: int
    shutdown: int
    torque: bool
    hardware_error: int
    voltage_v: float
    temperature_c: float

    @property
    def who(self) -> str:
        """Leg and id, for a person."""
        return f"{self.leg} (id {self.servo_id})"

    @property
    def return_delay_us(self) -> float:
        """How long it waits before it answers [us]."""
        return self.return_delay * RETURN_DELAY_UNIT_S * 1e6

    @property
    def has_shut_down(self) -> bool:
        """Whether a latched error keeps its torque off."""
        return bool(self.hardware_error & self.shutdown)

    @property
    def error_names(self) -> tuple[str, ...]:
        """The latched errors in words."""
        return hardware_error_names(self.hardware_error)


def read_condition(servo: CheckedServo) -> ServoCondition:
    """Ask one servo for its condition.

    Each request asks for another number of bytes, so that on a slow line a late answer to one cannot
    pass for the answer to the next.

    Raises:
        BusError: It does not answer soundly.
    """
    registers: dict[str, int] = {}
    for first, last in RUNS:
        registers |= servo.read_run(first, last)
    return ServoCondition(
        leg=servo.leg,
        servo_id=servo.servo_id,
        model=registers["model_number"],
        firmware=registers["firmware_version"],
        operating_mode=registers["operating_mode"],
        return_delay=registers["return_delay_time"],
        homing_offset=registers["homing_offset"],
        shutdown=registers["shutdown"],
        torque=bool(registers["torque_enable"]),
        hardware_error=registers["hardware_error_status"],
        voltage_v=registers["present_input_voltage"] * VOLTAGE_UNIT_V,
        temperature_c=float(registers["present_temperature"]),
    )
