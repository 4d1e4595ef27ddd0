"""Rebooting a servo without forgetting why: its cause and its turns are read first."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.clock import Clock
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.mx106 import TICKS_PER_TURN, hardware_error_names
from model.errors import BusError

# A servo takes a few tenths of a second to start.
REBOOT_LIMIT_S = 3.0
LOOK_AGAIN_S = 0.05
TELL_TRIES = 10  # longer together than a reboot whose answer was lost


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


def reboot_servo(
    servo: CheckedServo, clock: Clock, meanwhile: Callable[[], None] = lambda: None
) -> Reboot:
    """Read cause and turns, reboot, wait until it is back, and see that torque is off.

    Args:
        servo: The servo.
        clock: Where time comes from.
        meanwhile: Called again and again while it starts: what other servos must hear.

    Raises:
        BusError: It does not answer, does not come back, or comes back with torque on.
    """
    cause = servo.read("hardware_error_status")
    torque = bool(servo.read("torque_enable"))
    ticks_before = servo.read("present_position")
    began_ns = clock.now_ns()
    _tell(servo, clock, meanwhile)
    _wait_until_back(servo, clock, began_ns, meanwhile)
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


def _tell(servo: CheckedServo, clock: Clock, meanwhile: Callable[[], None]) -> None:
    """Tell it until it says that it will: twice does no harm, and a lost answer proves nothing."""
    for _ in range(TELL_TRIES):
        if servo.reboot():
            return
        meanwhile()
        clock.sleep_until_ns(clock.now_ns() + round(LOOK_AGAIN_S * 1e9))
    raise BusError(
        f"{servo.leg} (id {servo.servo_id}) did not answer to its reboot: check its cable",
        port=servo.port.name,
        ids=(servo.servo_id,),
    )


def _wait_until_back(
    servo: CheckedServo, clock: Clock, began_ns: int, meanwhile: Callable[[], None]
) -> None:
    while clock.now_ns() - began_ns < REBOOT_LIMIT_S * 1e9:
        # its word that it will reboot comes before it does: look only after a pause
        meanwhile()
        clock.sleep_until_ns(clock.now_ns() + round(LOOK_AGAIN_S * 1e9))
        if servo.answers():
            return
    raise BusError(
        f"{servo.leg} (id {servo.servo_id}) did not come back within {REBOOT_LIMIT_S:g} s of its "
        "reboot: switch its power off and on",
        port=servo.port.name,
        ids=(servo.servo_id,),
    )
