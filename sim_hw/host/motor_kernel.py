"""The motors of a plant as the servos' sensors see them. Compiled.

Products and sums in the order in which they are written, as numpy does it: the same bits with and without
machine code.
"""

from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.values.arrays import FloatArray, IntArray
from sim_hw.plant.leg_kernel import CURRENT, SUPPLY, TEMPERATURE

# Rows of what is read, in the order of ``MotorReadings``.
READINGS = 5


@in_place
@compiled
def motor_readings(
    state: FloatArray,
    columns: IntArray,
    mounting: FloatArray,
    scale: FloatArray,
    readings: FloatArray,
) -> None:
    """Read all motors.

    Args:
        state: Legs, as ``leg_kernel`` has them, (N, 8).
        columns: Of the angle and the speed in ``state`` that the encoders have, (2,).
        mounting: Zeros [ticks], ticks a radian, signs, (3, N).
        scale: Reading of each encoder over truth, (N,).
        readings: A row for each of ``MotorReadings``, (5, N); written.
    """
    for k in range(len(state)):
        sign = mounting[2, k]
        readings[0, k] = mounting[0, k] + mounting[1, k] * (scale[k] * state[k, columns[0]])
        readings[1, k] = sign * (scale[k] * state[k, columns[1]])
        readings[2, k] = sign * state[k, CURRENT]
        readings[3, k] = state[k, SUPPLY]
        readings[4, k] = state[k, TEMPERATURE]


def prepare() -> None:
    """Load or make the machine code, so that no answer waits for it."""
    compile_for(motor_readings, *given(2), *given(1, kind=COUNT), *given(2, 1), *out(2))
