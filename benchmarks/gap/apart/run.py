"""One run: a robot as it is on its day stands for a second, then walks and is recorded."""

import math
from typing import Any, NamedTuple

import mujoco
import numpy as np

from benchmarks.gap.apart.day import Day, draw_day
from benchmarks.gap.apart.fault import HEALTHY, Fault
from benchmarks.gap.apart.feet import Feet, foot_geoms
from benchmarks.gap.apart.gait import COMMAND_RATE_HZ, commanded_angles
from benchmarks.gap.apart.layout import JOINTS, FloatArray, IndexArray
from benchmarks.gap.apart.robot import built_robot
from benchmarks.gap.apart.run_table import RunTable
from benchmarks.gap.apart.sensors import measured
from benchmarks.gap.apart.servo import Servos

RUN_S = 14.0
BEFORE_S = 1.0  # of standing, not recorded
STEP_S = 0.001
STEPS_PER_SECOND = 1000
STEPS_PER_COMMAND = STEPS_PER_SECOND // COMMAND_RATE_HZ
STEPS_PER_RECORD = 10
GRAVITY_M_S2 = 9.81


class _Record(NamedTuple):
    """One row of a run."""

    time_s: float
    command_rad: FloatArray
    encoder_rad: FloatArray
    position_m: FloatArray
    roll_pitch_yaw_rad: tuple[float, float, float]
    foot_force_n: FloatArray


def simulated_run(
    period_s: float, seed: int, fault: Fault = HEALTHY, duration_s: float = RUN_S
) -> RunTable:
    """Return a run as it is recorded; the same arguments make the same run.

    Args:
        period_s: Of the gait.
        seed: Of everything that differs from run to run, and of noise.
        fault: What is wrong.
        duration_s: Of the record.
    """
    random = np.random.default_rng(seed)
    day = draw_day(random)
    commands_rad = commanded_angles(period_s, duration_s + BEFORE_S)
    records = _walked(day, fault, commands_rad, int((duration_s + BEFORE_S) * STEPS_PER_SECOND))
    true = RunTable(*(np.array(column) for column in zip(*records, strict=True)))
    return measured(true, day, fault, random)


def _walked(day: Day, fault: Fault, commands_rad: FloatArray, steps: int) -> list[_Record]:
    """What is true in each sample of a run; commands (samples, 12) are repeated while it stands before."""
    model = _model_of(day, fault)
    data = mujoco.MjData(model)
    angles, rates = _places(model)
    servos, feet = Servos(day, fault, commands_rad[0]), Feet(model, fault)
    _put_down(data, day)
    data.qpos[angles] = commands_rad[0] + servos.zero_rad
    encoder_ratio = fault.at_joints(fault.encoder_ratio, 1.0)
    late = round(fault.command_delay_s * COMMAND_RATE_HZ)
    before = round(BEFORE_S * COMMAND_RATE_HZ)
    trunk, records = model.body("trunk").id, []
    for step in range(steps):
        time_s = step * STEP_S - BEFORE_S
        if step % STEPS_PER_COMMAND == 0:
            sample = max(0, step // STEPS_PER_COMMAND - before)
            arrived_rad = commands_rad[max(0, sample - late)]
            encoder_rad = servos.sample(time_s, arrived_rad, data.qpos[angles])
            if step % STEPS_PER_RECORD == 0 and time_s >= 0:
                rotation = data.xmat[trunk].reshape(3, 3)
                records.append(
                    _Record(
                        time_s,
                        commands_rad[sample],
                        encoder_rad * encoder_ratio,
                        data.xpos[trunk].copy(),
                        _roll_pitch_yaw(rotation),
                        feet.mean_force_n(rotation),
                    )
                )
        data.qfrc_applied[rates] = servos.torque_nm()
        feet.pull(data)
        mujoco.mj_step(model, data)
        feet.feel(data)
    return records


def _model_of(day: Day, fault: Fault) -> Any:
    """MuJoCo's model of a day's robot on a day's floor."""
    model = mujoco.MjModel.from_xml_string(built_robot(day, fault))
    along_x, along_y = day.floor_slope
    down = -math.sqrt(1 - along_x * along_x - along_y * along_y)
    model.opt.gravity[:] = GRAVITY_M_S2 * np.array([along_x, along_y, down])
    _, rates = _places(model)
    model.dof_frictionloss[rates] = day.dry_friction_nm + fault.at_joints(
        fault.dry_friction_nm, 0.0
    )
    friction = day.foot_friction * fault.at_legs(fault.foot_friction_ratio, 1.0)
    model.geom_friction[foot_geoms(model), 0] = friction
    return model


def _places(model: Any) -> tuple[IndexArray, IndexArray]:
    """Where the joints' angles and rates are in MuJoCo's state, (12,) each."""
    joints = [model.joint(name) for name in JOINTS]
    angles = np.array([joint.qposadr[0] for joint in joints])
    return angles, np.array([joint.dofadr[0] for joint in joints])


def _put_down(data: Any, day: Day) -> None:
    """Place the trunk where it is at first."""
    data.qpos[:2] = day.first_position_m
    data.qpos[3] = math.cos(day.first_yaw_rad / 2)
    data.qpos[6] = math.sin(day.first_yaw_rad / 2)


def _roll_pitch_yaw(rotation: FloatArray) -> tuple[float, float, float]:
    """Angles of a rotation (3, 3) [rad]."""
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    return roll, -math.asin(rotation[2, 0]), math.atan2(rotation[1, 0], rotation[0, 0])
