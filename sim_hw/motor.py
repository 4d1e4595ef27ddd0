"""The geared motors of all servos: voltage to torque, friction budget, heat."""

import numpy as np

from model.signals import BoolArray, FloatArray
from sim_hw.plant_parameters import MotorParameters


def friction_budget(
    motor: MotorParameters, rate: FloatArray, motor_torque: FloatArray, load_torque: FloatArray
) -> FloatArray:
    """Largest torque that dry friction can take up, (N,) [N m].

    Args:
        motor: Parameters.
        rate: Output speed, (N,) [rad/s].
        motor_torque: Torque of the motor at the output, (N,) [N m].
        load_torque: Torque of the load on the output, (N,) [N m].

    Reference: Rhoban/bam, model m4 (Stribeck and load-dependent).
    """
    carried = np.abs(motor_torque - load_torque)
    decay = np.exp(-(np.abs(rate / motor.stribeck_speed) ** motor.stribeck_power))
    budget: FloatArray = motor.load * carried + decay * (
        motor.stribeck + motor.load_stribeck * carried
    )
    return budget


class Motors:
    """Electrical and thermal state of the motors.

    Args:
        motor: Parameters, the same for all.
        count: Number of motors.
        battery_v: Open-circuit voltage.
        battery_resistance: [ohm].
        ambient_c: [degC].
    """

    def __init__(
        self,
        motor: MotorParameters,
        count: int,
        battery_v: float,
        battery_resistance: float,
        ambient_c: float,
    ) -> None:
        self._motor = motor
        self._battery_v = battery_v
        self._battery_resistance = battery_resistance
        self._ambient_c = ambient_c
        self.current_a = np.zeros(count)
        self.temperature_c = np.full(count, ambient_c)
        self.supply_v = np.full(count, battery_v)
        self.applied_v = np.zeros(count)

    def drive(
        self, duty: FloatArray, driven: BoolArray, rate: FloatArray, dt_s: float
    ) -> FloatArray:
        """Apply duties; return the stall torque of the applied voltage, kt V/R, (N,) [N m].

        The back-EMF, kt^2/R times speed, is left to the integrator as damping where the output stage
        is on; where it is off no current flows.
        """
        m = self._motor
        bounded = np.clip(duty, -m.duty_limit, m.duty_limit)
        self.applied_v = np.where(driven, bounded * self.supply_v, 0.0)
        self.current_a = np.where(
            driven, (self.applied_v - m.torque_constant * rate) / m.resistance, 0.0
        )
        drawn = float(np.sum(np.abs(bounded * self.current_a)))
        self.supply_v = np.full_like(
            self.supply_v, self._battery_v - self._battery_resistance * drawn
        )
        heat_w = m.resistance * self.current_a**2
        final = self._ambient_c + m.thermal_resistance * heat_w
        self.temperature_c += (final - self.temperature_c) * (dt_s / m.thermal_time)
        return np.where(driven, m.torque_constant * self.applied_v / m.resistance, 0.0)
