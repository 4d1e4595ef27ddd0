"""One servo over one trial, compiled: position loop, DC motor, dry friction, play, pendulum.

Speed is stepped semi-implicitly (back-EMF and viscous friction are solved for, so that a stiff motor
stays stable), and dry friction takes at most what would stop the shaft within the step.
"""

import numpy as np
from scipy.constants import g as standard_gravity

from model.compiled import compiled
from model.values.arrays import FloatArray

# Places in the array of numbers.
(DELAY, LAG, PLAY, KP, KD, KI, DUTY_LIMIT, SUPPLY, TORQUE_CONSTANT, RESISTANCE, ARMATURE, MASS_LENGTH,
 LOAD_INERTIA, COULOMB, VISCOUS, STRIBECK, STRIBECK_SPEED, LOAD_FRICTION, BACKLASH, DROOP, BREAK_TORQUE,
 ENCODER_OFFSET, ENCODER_SCALE, DROOP_SIN, DROOP_COS, SPEED_LIMIT) = range(26)  # fmt: skip
NUMBERS = 26
SUBSTEP_S = 0.002


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
    target: FloatArray, period_s: float, angle: float, speed: float, p: FloatArray
) -> FloatArray:
    """Integrate a servo with a motor.

    Args:
        target: Where the position loop wants the shaft, (F,).
        period_s: Between frames.
        angle: Shaft at the first frame.
        speed: Its speed there.
        p: Numbers, (NUMBERS,).

    Returns:
        Shaft angle, duty, current at each frame, (F, 3).
    """
    frames = len(target)
    out = np.empty((frames, 3))
    steps = max(1, int(np.ceil(period_s / SUBSTEP_S)))
    dt = period_s / steps
    inertia = p[ARMATURE] + p[LOAD_INERTIA]
    kt, resistance = p[TORQUE_CONSTANT], p[RESISTANCE]
    damping = kt * kt / resistance + p[VISCOUS]
    shaft, integral, duty = angle, 0.0, 0.0
    before = target[0] - shaft
    for i in range(frames):
        last = min(i + 1, frames - 1)
        for s in range(steps):
            wanted = target[i] + (target[last] - target[i]) * s / steps
            error = wanted - shaft
            if s == 0:
                integral += p[KI] * error * period_s
                integral = min(max(integral, -p[DUTY_LIMIT]), p[DUTY_LIMIT])
            duty = p[KP] * error + integral + p[KD] * (error - before) / dt
            duty = min(max(duty, -p[DUTY_LIMIT]), p[DUTY_LIMIT])
            before = error
            if s == 0:
                out[i, 0] = shaft
                out[i, 1] = duty
                out[i, 2] = (duty * p[SUPPLY] - kt * speed) / resistance
            load = -p[MASS_LENGTH] * standard_gravity * np.sin(shaft)
            motor = kt * duty * p[SUPPLY] / resistance
            free = (speed + dt / inertia * (motor + load)) / (1.0 + dt / inertia * damping)
            dry = p[COULOMB] + p[LOAD_FRICTION] * abs(load)
            if p[STRIBECK] > 0.0:
                dry += p[STRIBECK] * np.exp(-abs(speed) / p[STRIBECK_SPEED])
            stop = dry * dt / inertia / (1.0 + dt / inertia * damping)
            speed = 0.0 if abs(free) <= stop else free - stop * np.sign(free)
            angle += dt * speed
            half = 0.5 * p[BACKLASH]
            if half > 0.0 and p[MASS_LENGTH] > 0.0 and abs(load) > 1e-9:
                # the load falls to the flank that its weight pushes to
                shaft = angle + half * np.sign(load)
            else:
                shaft = min(max(shaft, angle - half), angle + half)
    return out
