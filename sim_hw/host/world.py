"""The world behind the virtual devices: plant and firmware running together in fixed steps.

It knows the mounting of the servos (sign, zero) and of the transducers, and nothing of bytes.
"""

import numpy as np

from drivers.ati.settings import ForceSensorSettings
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import TICK_RAD
from model.compiled import compiles
from model.values.arrays import FloatArray
from model.values.readings import BodyTruth
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.host import motor_kernel, wrench_kernel
from sim_hw.host.motor_kernel import READINGS, motor_readings
from sim_hw.host.step_kernel import CompiledSteps
from sim_hw.host.wrench_kernel import mean_wrenches
from sim_hw.interfaces import FirmwareControl, MotorReadings
from sim_hw.plant.leg_kernel import MOTOR, MOTOR_RATE, SHAFT, SHAFT_RATE
from sim_hw.plant.plant import Plant
from sim_hw.plant.structure import GearSide
from sim_hw.twin.imu import VirtualImu
from sim_hw.twin.sensing import ForceChannel, SensorParameters

# Forces are kept so long: a transducer averages over its sample period, and its stream may come late.
KEPT_STEPS = 4096


class World:
    """Plant and firmware; ``sim_hw.interfaces.MotorWorld`` and ``WrenchSource``.

    Args:
        plant: The robot.
        firmware: The servos' control loops.
        servo_bus: How the servos are mounted.
        force_sensor: How the transducers are mounted.
        sensors: Errors of encoders and transducers; None for none.
        imu: An IMU on the body, None for none.
        seed: Of the transducers' coloured noise.
    """

    def __init__(
        self,
        plant: Plant,
        firmware: FirmwareControl,
        servo_bus: ServoBusSettings,
        force_sensor: ForceSensorSettings,
        sensors: SensorParameters | None = None,
        imu: VirtualImu | None = None,
        seed: int = 0,
    ) -> None:
        self.plant = plant
        self._imu = imu
        self._firmware = firmware
        signs = servo_bus.signs
        self._signs = signs.astype(np.float64)
        self._ticks_a_rad = self._signs / TICK_RAD
        self._zeros = servo_bus.zeros.astype(np.float64)
        self._origin = plant.parameters.shaft_position + force_sensor.offset_m
        known = sensors if sensors is not None else SensorParameters.healthy(len(signs))
        yaw = force_sensor.yaw_rad + known.force_yaw
        self._turned = np.array([np.cos(yaw), np.sin(yaw), force_sensor.up.astype(np.float64)])
        wrench_kernel.prepare()
        motor_kernel.prepare()
        self._channel = ForceChannel(known, seed)
        self._marker_share = known.marker_share
        loop = plant.parameters.drive.loop
        motor, shaft = plant.motor_angle_rad, plant.shaft_angle_rad  # views of what is now
        on_motor = loop.feedback is GearSide.MOTOR
        self._loop_angle = motor if on_motor else shaft
        self._loop_rate = plant.motor_rate_rad_s if on_motor else plant.shaft_rate_rad_s
        sides = (MOTOR, MOTOR_RATE), (SHAFT, SHAFT_RATE)
        self._encoder = np.array(sides[loop.encoder is not GearSide.MOTOR])
        self._late_steps = round(known.force_delay_s / plant.dt_s)
        self._scale = known.encoder_scale
        self._step_ns = round(plant.dt_s * 1e9)
        self._now_ns: int | None = None
        self._steps = 0
        self._forces = np.tile(plant.foot_force_B, (KEPT_STEPS, 1, 1))  # a ring, a row a step
        self._force_rows = [*self._forces]
        self._read_until = 0
        mounting = self._mounting = np.array([self._zeros, self._ticks_a_rad, self._signs])
        columns = sides[not on_motor]
        self._compiled = None
        if compiles() and isinstance(firmware, FirmwareBank):
            self._compiled = CompiledSteps(plant, firmware, mounting, columns)

    def advance_to(self, t_ns: int) -> None:
        """Run in whole steps up to a time, never beyond it. The first call sets the beginning."""
        if self._now_ns is None:
            self._now_ns = t_ns
        left = (t_ns - self._now_ns) // self._step_ns
        while left > 0:
            count = left
            if self._imu is not None:  # its next sample is due behind so many of them
                due_ns = self._imu.due_ns - self._now_ns
                count = min(left, max(1, -(-due_ns // self._step_ns)))
            left -= count
            self._now_ns += count * self._step_ns
            self._take(count)
            if self._imu is not None and self._now_ns >= self._imu.due_ns:
                self._imu.sample(self._now_ns, self.plant.places()[1])

    def stand_still_until(self, t_ns: int) -> None:
        """Skip the time until ``t_ns``, in which nothing happens; nothing if it is already there."""
        if self._now_ns is not None:
            self._now_ns = max(self._now_ns, t_ns)

    def _take(self, count: int) -> None:
        """Take steps: in one compiled call where the plant and its firmware have nothing out of the way."""
        compiled, plant = self._compiled, self.plant
        if compiled is None or not plant.plain or not compiled.fits:
            for _ in range(count):
                self._step()
            return
        compiled.run(count, self._steps, self._forces)
        self._steps += count
        plant.foot_force_B = self._force_rows[self._steps % KEPT_STEPS]

    def _step(self) -> None:
        plant = self.plant
        duty = self._firmware.duty(
            self._zeros + self._ticks_a_rad * self._loop_angle,
            self._signs * self._loop_rate,
            self._signs * plant.current_a,
            plant.dt_s,
        )
        plant.step(duty * self._signs, self._firmware.driven)
        self._steps += 1
        self._forces[self._steps % KEPT_STEPS] = plant.foot_force_B

    def motors(self) -> MotorReadings:
        """Return the motors as the servos see them."""
        state = self.plant.leg_state
        readings = np.empty((READINGS, len(state)))
        motor_readings(state, self._encoder, self._mounting, self._scale, readings)
        return MotorReadings(*readings)

    def jam(self, index: int, torque_n_m: float) -> None:
        """Give a shaft so much dry friction on top of its own; 0 frees it."""
        self.plant.jam(index, torque_n_m)

    def wrench(self, t_ns: int) -> FloatArray:
        """Mean wrench on each transducer between the last call's time and this one.

        Returns:
            (N, 6) [N, N m], sensor axes: the ground's force on the foot, moment about the transducer.
        """
        self.advance_to(t_ns)
        ahead = max(0, (self._now_ns or t_ns) - t_ns)
        last = self._steps - -(-ahead // self._step_ns)
        first = self._read_until + 1
        if first <= last:
            self._read_until = last
        else:  # asked again within a step: the same answer
            first = last
        late, lever = self._late_steps, self.plant.feet_B - self._origin
        begin = max(first, last - KEPT_STEPS // 2)
        wrench = np.empty((len(lever), 6))
        mean_wrenches(self._forces, begin - late, last - late, lever, self._turned, wrench)
        return self._channel.report(wrench, t_ns)

    def places(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the body's position and quaternion x y z w, and the feet as their markers show them."""
        return self.plant.marker_places(self._marker_share)

    def truth(self, t_ns: int) -> BodyTruth:
        """Advance to a time and return where everything is."""
        self.advance_to(t_ns)
        return self.plant.truth(t_ns)
