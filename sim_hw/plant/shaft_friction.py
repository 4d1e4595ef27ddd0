"""Dry friction of shafts that are tighter than their motors, as a torque."""

from drivers.dynamixel.units import DUTY_FULL, TICK_RAD
from model.values.arrays import FloatArray
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.structure import LoopKind, ServoLoop

P_GAIN = 850  # of the registers from the factory; ROBOTIS e-manual, MX-106(2.0), Position P Gain
COUNTS_A_TICK = P_GAIN / 128


def duty_a_rad(loop: ServoLoop) -> float:
    """Return the duty with which a loop answers a standing error [1/rad], before an integral grows."""
    if loop.kind is LoopKind.CASCADED:
        return loop.angle_gain * loop.speed_gain
    return loop.gain * COUNTS_A_TICK / (DUTY_FULL * TICK_RAD)


def shaft_friction(plant: PlantParameters) -> FloatArray:
    """Return the dry friction of each shaft beside its motor's own, (N,) [N m].

    With it the servo's loop sets a shaft in motion at the error that ``DriveParameters.friction_rad`` says,
    if the battery is full. The gear's friction grows with what it carries, this friction too.
    """
    torque = plant.drive.friction_rad.copy()
    for k, motor in enumerate(plant.motors):
        stall = motor.torque_constant * motor.battery_v / motor.resistance
        carried = 1.0 + motor.load + motor.load_stribeck
        torque[k] *= duty_a_rad(plant.drive.loop) * stall / carried
    return torque
