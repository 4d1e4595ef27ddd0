"""The table of one run: what is recorded at 100 Hz."""

from dataclasses import dataclass

from benchmarks.gap.apart.layout import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RunTable:
    """One run, T samples.

    Attributes:
        time_s: (T,).
        command_rad: Of each joint, (T, 12).
        encoder_rad: Of each joint, (T, 12).
        position_m: Of the trunk on the floor, (T, 3).
        roll_pitch_yaw_rad: Of the trunk, (T, 3).
        foot_force_n: Of the floor on each foot, in the trunk's axes, (T, 6, 3).
    """

    time_s: FloatArray
    command_rad: FloatArray
    encoder_rad: FloatArray
    position_m: FloatArray
    roll_pitch_yaw_rad: FloatArray
    foot_force_n: FloatArray
