"""Who knows what of whom inside the virtual hardware.

The devices (virtual servos, virtual WNet) see the physical world only through these protocols, and
whoever hosts them (the device process, a test) sees a device only as something to serve.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from model.values.arrays import BoolArray, FloatArray
from model.values.readings import BodyTruth


class MotorReadings(NamedTuple):
    """The motors as the servos' sensors see them, each in its servo's own sense.

    Attributes:
        ticks: Output position, continuous, before quantisation, (N,) [ticks, 4096 a turn].
        rate_rad_s: Output speed, (N,) [rad/s].
        current_a: Motor current, signed, (N,) [A].
        supply_v: Voltage at each servo, (N,) [V].
        temperature_c: Motor temperature, (N,) [degC].
    """

    ticks: FloatArray
    rate_rad_s: FloatArray
    current_a: FloatArray
    supply_v: FloatArray
    temperature_c: FloatArray


class MotorWorld(Protocol):
    """The motors as a servo's firmware sees them. N servos, in the order of the robot file."""

    def advance_to(self, t_ns: int) -> None:
        """Let the world run until ``t_ns``; nothing happens if it is already there."""
        ...

    def motors(self) -> MotorReadings:
        """Return what the sensors give now."""
        ...

    def jam(self, index: int, torque_n_m: float) -> None:
        """Give a shaft so much dry friction on top of its own; 0 frees it."""
        ...


class FirmwareControl(Protocol):
    """The firmware's control loop, called by the world once every physics step."""

    @property
    def driven(self) -> BoolArray:
        """True where the output stage is on (torque enabled and not shut down), (N,)."""
        ...

    def duty(
        self, ticks: FloatArray, rate_rad_s: FloatArray, current_a: FloatArray, dt_s: float
    ) -> FloatArray:
        """Return the PWM duty of each servo, -1 to 1, in the servo's own sense, (N,)."""
        ...


class WrenchSource(Protocol):
    """The transducers as the force-torque unit sees them."""

    def wrench(self, t_ns: int) -> FloatArray:
        """Mean wrench since the last call, up to ``t_ns``, per leg.

        Returns:
            (N, 6): Fx Fy Fz [N] and Tx Ty Tz [N m] in sensor axes; the ground's force on the foot.
        """
        ...


class HostedWorld(MotorWorld, WrenchSource, Protocol):
    """A world that virtual devices stand in: motors, transducers, perhaps a body."""

    def stand_still_until(self, t_ns: int) -> None:
        """Skip the time until ``t_ns``, in which nothing happens."""
        ...

    def truth(self, t_ns: int) -> BodyTruth | None:
        """Let the world run and return where the body is, None where there is none."""
        ...


class ServoWire(Protocol):
    """A servo bus as the host's end sees it: bytes in, bytes out, each at its time.

    A wire whose adapter has been unplugged raises ``ConnectionLost`` from ``receive`` and ``replies``.
    """

    def poll(self, t_ns: int) -> None:
        """Let time pass."""
        ...

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes whose last one arrived at ``t_ns``."""
        ...

    def next_reply_ns(self) -> int | None:
        """When there may be something to read, None if nothing is under way."""
        ...

    def replies(self, t_ns: int) -> bytes:
        """Return what has arrived by a time."""
        ...


class ConsoleEnd(Protocol):
    """One console session of the force-torque unit, as the host's end sees it."""

    def give(self, data: bytes, t_ns: int) -> None:
        """Send bytes to the unit."""
        ...

    def take(self, t_ns: int) -> bytes:
        """Return what has been printed by a time, empty if nothing."""
        ...

    def next_due_ns(self) -> int | None:
        """When there may be something to take, None if nothing is waiting."""
        ...


class Served(Protocol):
    """A device with descriptors and a schedule; the host calls ``service`` in a select loop."""

    def filenos(self) -> Sequence[int]:
        """File descriptors to watch for input."""
        ...

    def next_due_ns(self) -> int | None:
        """When the device next wants to act by itself, None if it waits for input."""
        ...

    def service(self, now_ns: int) -> None:
        """Read what has arrived without blocking, send what is due."""
        ...

    def close(self) -> None:
        """Give back every descriptor."""
        ...
