"""Motor, gear, linkage and springs of all legs over one MuJoCo step, compiled.

MuJoCo carries the body, the feet on their springs and the contacts. What moves the springs' ends is
here: the motor turns the crank, the leg's end goes where its kind says, and the springs' forces go both
ways, to the foot (``applied``) and back on the crank.
"""

import math

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.values.arrays import BoolArray, FloatArray, IntArray
from sim_hw.plant.leg_path import leg_point
from sim_hw.plant.motor import (
    BATTERY_RESISTANCE,
    BATTERY_V,
    DUTY_LIMIT,
    RESISTANCE,
    TORQUE_CONSTANT,
    current_of,
    slowed,
    turned,
    warmed,
)
from sim_hw.plant.parameters import PlantParameters

# State of a leg, a row: motor and shaft (the encoder's side of the gear), the motor's condition.
STATE_NUMBERS = 8
MOTOR, MOTOR_RATE, SHAFT, SHAFT_RATE, CURRENT, TEMPERATURE, SUPPLY, DUTY = range(STATE_NUMBERS)
# What a leg is made of.
LEG_NUMBERS = 14
(
    STIFFNESS, DAMPING, SIDE_STIFFNESS, SIDE_DAMPING, LEG_OFFSET, LEG_PLAY, CRANK_OFFSET, COMPLIANCE,
    BACKLASH, ROLL_STIFFNESS, ROLL_DAMPING, ROLL_ZERO, JAM, HARDENING,
) = range(LEG_NUMBERS)  # fmt: skip
# Inertia on the encoder's side of a gear with play or twist: crank, coupler and foot; assumed.
SHAFT_INERTIA = 0.002
# A gear with play only is this stiff where the teeth touch [N m/rad].
TOOTH_STIFFNESS = 1500.0
TOOTH_DAMPING = 0.5
ROLL_INERTIA = 0.001
ROLLING = (200.0, 0.9)  # stiffness [N m/rad] and damping that turn a rolling foot with its link


def leg_rows(plant: PlantParameters, coupler_zero: FloatArray) -> FloatArray:
    """Return what the compiled code needs of each leg, (N, 14)."""
    rows = np.zeros((plant.legs, LEG_NUMBERS))
    rows[:, STIFFNESS], rows[:, DAMPING] = plant.stiffness, plant.damping
    rows[:, SIDE_STIFFNESS] = plant.side_stiffness[:, 0]
    rows[:, SIDE_DAMPING] = side_damping(plant)[:, 0]
    rows[:, LEG_OFFSET], rows[:, LEG_PLAY] = plant.leg_offset, plant.leg_play
    rows[:, CRANK_OFFSET] = plant.drive.crank_offset
    rows[:, COMPLIANCE], rows[:, BACKLASH] = plant.drive.compliance, plant.drive.backlash
    rows[:, ROLL_STIFFNESS], rows[:, ROLL_DAMPING] = ROLLING
    rows[:, ROLL_ZERO], rows[:, HARDENING] = coupler_zero, plant.hardening
    return rows


def side_damping(plant: PlantParameters) -> FloatArray:
    """Return the damping of the side springs, (N, 2) [N s/m]."""
    critical: FloatArray = 2 * np.sqrt(plant.side_stiffness * plant.foot_mass)
    return plant.side_damping_ratio * critical


@in_place
@compiled
def _gear_torque(row: FloatArray, twist: float, rate: float) -> float:
    """Torque through a gear with twist and play, from motor to shaft.

    Physics of its own: the diagnosis has its play from ``model.motion.filters``, and is tested against
    this.
    """
    half = row[BACKLASH] / 2
    if abs(twist) <= half:
        return 0.0
    stiffness = 1.0 / (row[COMPLIANCE] + 1.0 / TOOTH_STIFFNESS)
    torque: float = stiffness * (twist - math.copysign(half, twist)) + TOOTH_DAMPING * rate
    return torque


@in_place
@compiled
def turn_legs(
    dt_s: float,
    substeps: int,
    motors: FloatArray,
    geometry: FloatArray,
    rows: FloatArray,
    state: FloatArray,
    duty: FloatArray,
    driven: BoolArray,
    foot_q: IntArray,
    foot_v: IntArray,
    roll_v: IntArray,
    qpos: FloatArray,
    qvel: FloatArray,
    applied: FloatArray,
) -> None:
    """Turn the cranks for one MuJoCo step and write the forces that the springs' moving ends make.

    Args:
        dt_s: MuJoCo's step.
        substeps: Steps taken here in one of MuJoCo's.
        motors: ``motor_row`` of each leg's motor, (N, 15).
        geometry: ``leg_geometry``.
        rows: ``leg_rows``.
        state: Legs, (N, 8); changed.
        duty: PWM duty, leg's sense, (N,).
        driven: Where the output stage is on, (N,).
        foot_q: Addresses of the feet's x, y, z in ``qpos``, (N, 3).
        foot_v: The same in ``qvel`` and ``applied``.
        roll_v: Addresses of rolling feet's hinges in ``qvel``, one less than in ``qpos``; -1 for none.
        qpos: MuJoCo's.
        qvel: MuJoCo's.
        applied: MuJoCo's ``qfrc_applied``; changed.
    """
    h = dt_s / substeps
    drawn = 0.0
    for k in range(len(duty)):
        row, leg, motor = rows[k], state[k], motors[k]
        kt, resistance, limit = motor[TORQUE_CONSTANT], motor[RESISTANCE], motor[DUTY_LIMIT]
        level = min(max(duty[k], -limit), limit) if driven[k] else 0.0
        voltage = level * leg[SUPPLY]
        emf = kt * kt / resistance if driven[k] else 0.0
        stall = kt * voltage / resistance
        qx, qz = qpos[foot_q[k, 0]], qpos[foot_q[k, 2]]
        vx, vz = qvel[foot_v[k, 0]], qvel[foot_v[k, 2]]
        elastic = row[COMPLIANCE] > 0 or row[BACKLASH] > 0
        push_x = push_z = push_roll = 0.0
        for _ in range(substeps):
            crank = leg[SHAFT] + row[CRANK_OFFSET]
            x, z, dx, dz, coupler, turn = leg_point(geometry[k], crank)
            rate = leg[SHAFT_RATE]
            gap = z - row[LEG_OFFSET] - qz  # the leg's play lies between its spring and its end
            free = min(max(gap, -row[LEG_PLAY] / 2), row[LEG_PLAY] / 2)
            fx = row[SIDE_STIFFNESS] * (x - qx) + row[SIDE_DAMPING] * (dx * rate - vx)
            harder = row[HARDENING] * gap * gap * gap
            fz = row[STIFFNESS] * (gap - free) + row[DAMPING] * (dz * rate - vz) + harder
            load = -(fx * dx + fz * dz)
            push_x += row[SIDE_STIFFNESS] * x + row[SIDE_DAMPING] * dx * rate
            push_z += row[STIFFNESS] * (z - row[LEG_OFFSET] - free) + row[DAMPING] * dz * rate
            push_z += harder
            if roll_v[k] >= 0:
                wanted = row[ROLL_ZERO] - coupler  # a turn from +x towards +z is negative about y
                at, speed = qpos[roll_v[k] + 1], qvel[roll_v[k]]
                k_roll, d_roll = row[ROLL_STIFFNESS], row[ROLL_DAMPING]
                load += turn * (k_roll * (wanted - at) + d_roll * (-turn * rate - speed))
                push_roll += k_roll * wanted - d_roll * turn * rate
            if elastic:
                torque = _gear_torque(row, leg[MOTOR] - leg[SHAFT], leg[MOTOR_RATE] - rate)
                leg[MOTOR_RATE] = turned(motor, leg[MOTOR_RATE], stall, emf, -torque, 0.0, h)
                leg[MOTOR] += h * leg[MOTOR_RATE]
                momentum = SHAFT_INERTIA * rate + h * (torque + load)
                leg[SHAFT_RATE] = slowed(momentum, h * row[JAM]) / SHAFT_INERTIA
                leg[SHAFT] += h * leg[SHAFT_RATE]
            else:
                leg[SHAFT_RATE] = turned(motor, rate, stall, emf, load, row[JAM], h)
                leg[SHAFT] += h * leg[SHAFT_RATE]
                leg[MOTOR], leg[MOTOR_RATE] = leg[SHAFT], leg[SHAFT_RATE]
        applied[foot_v[k, 0]] = push_x / substeps
        applied[foot_v[k, 2]] = push_z / substeps
        if roll_v[k] >= 0:
            applied[roll_v[k]] = push_roll / substeps
        leg[CURRENT] = current_of(motor, voltage, leg[MOTOR_RATE]) if driven[k] else 0.0
        leg[TEMPERATURE] = warmed(motor, leg[TEMPERATURE], leg[CURRENT], dt_s)
        leg[DUTY] = level
        drawn += abs(level * leg[CURRENT])
    for k in range(len(duty)):
        state[k, SUPPLY] = motors[k, BATTERY_V] - motors[k, BATTERY_RESISTANCE] * drawn


def prepare() -> None:
    """Load or make the machine code, so that no step waits for it."""
    compile_for(
        turn_legs, NUMBER, COUNT, *given(2, 2, 2), *out(2), *given(1), *given(1, kind=FLAG),
        *given(2, 2, 1, kind=COUNT), *given(1, 1), *out(1),
    )  # fmt: skip
