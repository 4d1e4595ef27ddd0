"""One servo over one trial, compiled: position loop, DC motor, dry friction, play, pendulum.

Speed is stepped semi-implicitly (back-EMF and viscous friction are solved for, so that a stiff motor
stays stable), and dry friction takes at most what would stop the shaft within the step.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import compiled
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY

UNLIMITED_RAD_S = 100.0
SUBSTEP_S = 0.002


class ServoNumbers(NamedTuple):
    """A servo, as it is nominally unless its file or a cause says otherwise; SI units."""

    kp_duty_per_rad: float = 4.0
    kd: float = 0.0  # duty per rad/s of falling error
    ki: float = 0.0  # duty per rad s
    duty_limit: float = 1.0
    delay_s: float = 0.0
    supply_v: float = 12.0
    torque_constant_nm_a: float = 1.0  # at the shaft, which is also volts per rad/s
    resistance_ohm: float = 1.0
    armature_kg_m2: float = 0.01  # rotor and gears at the shaft
    load_kg_m: float = 0.0  # mass of the pendulum times its length; angle 0 hangs down
    load_kg_m2: float = 0.0
    coulomb_nm: float = 0.0
    viscous_nm_s: float = 0.0
    lag_s: float = 0.0
    play_rad: float = 0.0
    speed_limit_rad_s: float = UNLIMITED_RAD_S
    stribeck_nm: float = 0.0
    stribeck_rad_s: float = 0.5
    load_friction: float = 0.0  # share of the load torque
    backlash_rad: float = 0.0
    break_nm: float = 0.0  # torque from which a load pushes an ideal shaft through its play
    droop_rad_nm: float = 0.0
    droop_sin_rad: float = 0.0
    droop_cos_rad: float = 0.0
    encoder_offset_rad: float = 0.0
    encoder_scale: float = 1.0


def pushed_side(torque_nm: FloatArray, break_nm: float) -> FloatArray:
    """Which flank of its play a pushed shaft lies at, -1 to 1, (F,); it stays where it was left."""
    side = np.where(np.abs(torque_nm) > break_nm, np.sign(torque_nm), 0.0)
    last = np.maximum.accumulate(np.where(side != 0.0, np.arange(len(side)), 0))
    pushed: FloatArray = side[last]
    return pushed


@compiled
def speed_limited(values: FloatArray, limit_rad_s: float, period_s: float) -> FloatArray:
    """What follows a signal no faster than a limit, (F,)."""
    out = np.empty_like(values)
    most = limit_rad_s * period_s
    at = values[0]
    for i in range(len(values)):
        at += min(max(values[i] - at, -most), most)
        out[i] = at
    return out


@compiled
def run_motor(
    target: FloatArray, period_s: float, angle: float, speed: float, p: ServoNumbers
) -> FloatArray:
    """Integrate a servo with a motor.

    Args:
        target: Where the position loop wants the shaft, (F,).
        period_s: Between frames.
        angle: Shaft at the first frame.
        speed: Its speed there.
        p: The servo.

    Returns:
        Shaft angle, duty, current at each frame, (F, 3).
    """
    frames = len(target)
    out = np.empty((frames, 3))
    steps = max(1, int(np.ceil(period_s / SUBSTEP_S)))
    dt = period_s / steps
    inertia = p.armature_kg_m2 + p.load_kg_m2
    kt, resistance = p.torque_constant_nm_a, p.resistance_ohm
    damping = kt * kt / resistance + p.viscous_nm_s
    shaft, integral, duty = angle, 0.0, 0.0
    before = target[0] - shaft
    for i in range(frames):
        last = min(i + 1, frames - 1)
        for s in range(steps):
            wanted = target[i] + (target[last] - target[i]) * s / steps
            error = wanted - shaft
            if s == 0:
                integral += p.ki * error * period_s
                integral = min(max(integral, -p.duty_limit), p.duty_limit)
            duty = p.kp_duty_per_rad * error + integral + p.kd * (error - before) / dt
            duty = min(max(duty, -p.duty_limit), p.duty_limit)
            before = error
            if s == 0:
                out[i, 0] = shaft
                out[i, 1] = duty
                out[i, 2] = (duty * p.supply_v - kt * speed) / resistance
            load = -p.load_kg_m * STANDARD_GRAVITY * np.sin(shaft)
            motor = kt * duty * p.supply_v / resistance
            free = (speed + dt / inertia * (motor + load)) / (1.0 + dt / inertia * damping)
            dry = p.coulomb_nm + p.load_friction * abs(load)
            if p.stribeck_nm > 0.0:
                dry += p.stribeck_nm * np.exp(-abs(speed) / p.stribeck_rad_s)
            stop = dry * dt / inertia / (1.0 + dt / inertia * damping)
            speed = 0.0 if abs(free) <= stop else free - stop * np.sign(free)
            angle += dt * speed
            half = 0.5 * p.backlash_rad
            if half > 0.0 and p.load_kg_m > 0.0 and abs(load) > 1e-9:
                # the load falls to the flank that its weight pushes to
                shaft = angle + half * np.sign(load)
            else:
                shaft = min(max(shaft, angle - half), angle + half)
    return out
