"""A robot hung in a frame: motors without ground under them, feet that a hand can press, a cable to pull.

The mounting (sign and zero of each servo, yaw of each transducer) is that of the robot which is really
there; the robot file that a driver uses may say something else. What hangs on the transducers (the legs)
weighs nothing here, and a press has no lever: forces are right, moments are zero.
"""

import numpy as np

from drivers.ati.settings import ForceSensorSettings
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import TICK_RAD
from model.errors import ConnectionLost
from model.values.arrays import FloatArray
from sim_hw.host.bench_world import BenchWorld
from sim_hw.interfaces import FirmwareControl, ServoWire

# Where the shafts hang before anybody has turned them, leg by leg, from mid-stance [rad].
HANGING_RAD = (0.35, -0.2, 0.15)


class HungWorld(BenchWorld):
    """The bench as a robot in a frame.

    Args:
        firmware: The servos' control loops.
        servo_bus: How the servos are really mounted.
        force_sensor: How the transducers are really mounted.
        supply_v: Voltage at the servos.
    """

    def __init__(
        self,
        firmware: FirmwareControl,
        servo_bus: ServoBusSettings,
        force_sensor: ForceSensorSettings,
        supply_v: float,
    ) -> None:
        super().__init__(firmware, servo_bus.zeros, 0.0, servo_bus.models, supply_v)
        self._mounted = servo_bus
        self._sensors = force_sensor
        self.turn_by_hand(np.resize(HANGING_RAD, len(servo_bus.ids)))

    @property
    def shaft_angle_rad(self) -> FloatArray:
        """Where the shafts really are, in the leg's sense from mid-stance, (N,) [rad]."""
        ticks = (self._ticks - self._mounted.zeros) * self._mounted.signs
        angle: FloatArray = ticks * TICK_RAD
        return angle

    def turn_by_hand(self, angle_rad: FloatArray) -> None:
        """Turn shafts without torque to angles in the leg's sense, (N,) [rad]; NaN leaves one alone."""
        ticks = self._mounted.zeros + self._mounted.signs * angle_rad / TICK_RAD
        self._ticks = np.where(np.isfinite(ticks), ticks, self._ticks)

    def press(self, leg: int, force_B: FloatArray) -> None:  # noqa: N803 - frame suffix
        """Press one foot with a force in body axes, (3,) [N], and no other; zeros let it go."""
        (fx, fy, fz), yaw, up = force_B, self._sensors.yaw_rad[leg], self._sensors.up[leg]
        c, s = np.cos(yaw), np.sin(yaw)
        self._wrench[:] = 0.0
        self._wrench[leg, :3] = c * fx + s * fy, up * (c * fy - s * fx), up * fz


class Cable:
    """``sim_hw.interfaces.ServoWire`` behind a USB cable that can be pulled.

    Args:
        wire: The wire.
    """

    def __init__(self, wire: ServoWire) -> None:
        self._wire = wire
        self.plugged = True

    def poll(self, t_ns: int) -> None:
        """Let time pass; servos live on without a cable."""
        self._wire.poll(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the host.

        Raises:
            ConnectionLost: The cable is out.
        """
        self._need()
        self._wire.receive(data, t_ns, baud_rate)

    def next_reply_ns(self) -> int | None:
        """When there may be something to read."""
        return self._wire.next_reply_ns()

    def replies(self, t_ns: int) -> bytes:
        """Return what has arrived by a time.

        Raises:
            ConnectionLost: The cable is out.
        """
        self._need()
        return self._wire.replies(t_ns)

    def _need(self) -> None:
        if not self.plugged:
            raise ConnectionLost("the virtual adapter is gone: was the cable pulled?")
