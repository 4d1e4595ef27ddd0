"""Rebooting a servo without forgetting why: its cause and its turns are read first."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.clock import Clock
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.registers import hardware_error_names
from drivers.dynamixel.units import TICKS_PER_TURN

# A servo takes a few tenths of a second to start.
REBOOT_LIMIT_S = 3.0
LOOK_AGAIN_S = 0.05
REQUEST_TRIES = 10  # longer together than a reboot whose answer was lost


@dataclass(frozen=True, slots=True)
class Reboot:
    """One reboot.

    Attributes:
        leg: Leg name.
        servo_id: Dynamixel id.
        cause: Hardware error before the reboot, bits of ``HardwareError``; the servo forgets it.
        torque_before: Whether torque was on.
        ticks_before: Position before [ticks].
        ticks_after: Position after [ticks]; the shaft may have moved under its load.
        error_after: Hardware error after it; not 0 where the cause persists.
        duration_s: Time until it answered again [s].
    """

    leg: str
    servo_id: int
    cause: int
    torque_before: bool
    ticks_before: int
    ticks_after: int
    error_after: int
    duration_s: float

    @property
    def turns_lost(self) -> int:
        """Whole turns that the servo has forgotten, with sign."""
        return round((self.ticks_before - self.ticks_after) / TICKS_PER_TURN)

    @property
    def cause_names(self) -> tuple[str, ...]:
        """The cause in words, empty if there was no hardware error."""
        return hardware_error_names(self.cause)


def reboot_servo(servo: CheckedServo, meanwhile: Callable[[], None] = lambda: None) -> Reboot:
    """Read cause and turns, reboot, wait until it is back, and see that torque is off.

    Args:
        servo: The servo.
        meanwhile: Called again and again while it starts: what other servos must receive.

    Raises:
        BusError: It does not answer, does not come back, or comes back with torque on.
    """
    clock = servo.port.clock
    cause = servo.read("hardware_error_status")
    torque = bool(servo.read("torque_enable"))
    ticks_before = servo.read("present_position")
    began_ns = clock.now_ns()
    _request(servo, meanwhile)
    _wait_until_back(servo, began_ns + round(REBOOT_LIMIT_S * 1e9), meanwhile)
    servo.write_verified("torque_enable", 0)
    return Reboot(
        leg=servo.leg,
        servo_id=servo.servo_id,
        cause=cause,
        torque_before=torque,
        ticks_before=ticks_before,
        ticks_after=servo.read("present_position"),
        error_after=servo.read("hardware_error_status"),
        duration_s=(clock.now_ns() - began_ns) * 1e-9,
    )


def _request(servo: CheckedServo, meanwhile: Callable[[], None]) -> None:
    """Request a reboot until it is acknowledged: twice does no harm, and a lost answer proves nothing."""
    for _ in range(REQUEST_TRIES):
        if servo.reboot():
            return
        meanwhile()
        _pause(servo.port.clock)
    raise servo.error("did not answer to its reboot: check its cable")


def _wait_until_back(servo: CheckedServo, until_ns: int, meanwhile: Callable[[], None]) -> None:
    clock = servo.port.clock
    while clock.now_ns() < until_ns:
        meanwhile()
        _pause(clock)  # it acknowledges before it reboots: look only after a pause
        if servo.answers():
            return
    raise servo.error(
        f"did not come back within {REBOOT_LIMIT_S:g} s of its reboot: switch its power off and on"
    )


def _pause(clock: Clock) -> None:
    clock.sleep_until_ns(clock.now_ns() + round(LOOK_AGAIN_S * 1e9))
