"""Trials of servos and of a sliding body, made for tests."""

import math

import numpy as np

from model.values.arrays import FloatArray
from record.trial.header import SERVO_BENCH, SLIDING_BODY, TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

MOTOR = """
kind = "servo_bench"
[joint.arm]
controller = { kp_duty_per_rad = 4.0, kd = 0.0, ki = 0.0, duty_limit = 1.0, delay_s = 0.0 }
motor = { supply_v = 7.4, torque_constant_nm_a = 0.5, resistance_ohm = 4.0, armature_kg_m2 = 0.002 }
load = { mass_kg = 0.49, length_m = 0.10 }
friction = { coulomb_nm = 0.02, viscous_nm_s = 0.01 }
"""
IDEAL = 'kind = "servo_bench"\n[joint.arm]\n'


def servo_trial(
    robot: str, command: FloatArray, shaft: FloatArray | None = None, hz: float = 50.0,
    torque: FloatArray | None = None, frequency: float = math.nan,
) -> Trial:  # fmt: skip
    header = TrialHeader(
        SERVO_BENCH, ("arm",), "other", frequency, hz, "", TrialNoise(shaft_rad=0.001),
        "bench.toml", robot,
    )  # fmt: skip
    columns = [
        TableColumn("time_s", np.arange(len(command)) / hz),
        TableColumn("command_arm_rad", command),
        TableColumn("shaft_arm_rad", command if shaft is None else shaft),
    ]
    if torque is not None:
        columns.append(TableColumn("torque_arm_nm", torque))
    return build_trial(header, tuple(columns))


def slide_trial(position: FloatArray, hz: float = 148.0, law: str = "viscous") -> Trial:
    robot = f'kind = "sliding_body"\n[body]\nmass = 0.37\n[contact]\nlaw = "{law}"\nmu = 0.2\n'
    header = TrialHeader(
        SLIDING_BODY,
        (),
        "",
        math.nan,
        hz,
        "",
        TrialNoise(body_position_m=0.0002),
        "body.toml",
        robot,
    )
    columns = [TableColumn("time_s", np.arange(len(position)) / hz)]
    columns += [TableColumn(f"body_{axis}_m", position[:, i]) for i, axis in enumerate("xy")]
    return build_trial(header, tuple(columns))
