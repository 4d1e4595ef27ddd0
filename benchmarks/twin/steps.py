"""Steps and solvers of the twin: five seconds of walking against Newton's method at 0.125 ms.

The shafts follow the gait by the servos' position loop, without bytes, so that only the physics differs.
Forces are compared as means over 10 ms. Times are processor time for 1 ms, medians over pieces of 0.5 s.
"""

import time
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from gaits.catalog import make_gait
from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant

SECONDS = 5.0
FREQUENCY_HZ = 0.2
RISE_S = 2.0
PIECE_STEPS = 500
AVERAGED_STEPS = 10
# Duty per radian of the servos' position loop at its factory gain (KPP 850 of 885 PWM).
GAIN = 4.89


@dataclass(frozen=True)
class Way:
    """A way to integrate: MuJoCo steps in a millisecond, steps of motors in each, solver."""

    label: str
    substeps: int
    servo_substeps: int
    solver: int


@dataclass(frozen=True)
class Walked:
    """Places of the body every 10 ms (T, 3) [m], mean forces (T, N, 3) [N], processor time a ms [us]."""

    place: FloatArray
    force: FloatArray
    cost_us: float


PGS = int(mujoco.mjtSolver.mjSOL_PGS)
NEWTON = int(mujoco.mjtSolver.mjSOL_NEWTON)
REFERENCE = Way("0.125 ms, Newton", 8, 2, NEWTON)
WAYS = (
    Way("1 ms, PGS", 1, 4, PGS),
    Way("0.5 ms, PGS (used)", 2, 2, PGS),
    Way("0.5 ms, Newton", 2, 2, NEWTON),
    Way("0.25 ms, PGS", 4, 1, PGS),
)


def walk(gait_name: str, way: Way) -> Walked:
    """Stand up into the gait's start pose, then walk."""
    robot = load_robot().parameters
    gait = make_gait(gait_name, robot)
    parameters = replace(
        PlantParameters.nominal(robot), substeps=way.substeps, servo_substeps=way.servo_substeps
    )
    plant = Plant(parameters)
    plant.model.opt.solver = way.solver
    on = np.ones(parameters.legs, dtype=bool)
    steps = round(SECONDS / plant.dt_s)
    phase: FloatArray = gait.start_phase + FREQUENCY_HZ * plant.dt_s * np.arange(
        steps, dtype=np.float64
    )
    goals = gait.motion(phase, 0.0).angle_rad
    began = plant.shaft_angle_rad.copy()
    rise = round(RISE_S / plant.dt_s)
    for at in range(rise):
        share = min(1.0, 2 * at / rise)
        goal = began + share * (goals[0] - began)
        plant.step(np.clip(GAIN * (goal - plant.motor_angle_rad), -1, 1), on)
    places, forces, costs = [], [], []
    start = plant.places()[0].copy()
    for first in range(0, steps, PIECE_STEPS):
        clock = time.process_time()
        for at in range(first, min(first + PIECE_STEPS, steps)):
            plant.step(np.clip(GAIN * (goals[at] - plant.motor_angle_rad), -1, 1), on)
            forces.append(plant.foot_force_B.copy())
            if at % AVERAGED_STEPS == AVERAGED_STEPS - 1:
                places.append(plant.places()[0] - start)
        costs.append((time.process_time() - clock) / PIECE_STEPS)
    mean = np.array(forces).reshape(-1, AVERAGED_STEPS, parameters.legs, 3).mean(axis=1)
    return Walked(np.array(places), mean, 1e6 * float(np.median(costs)))


def main() -> None:
    print("| gait, way | step, solver | largest difference of place | forces, RMS | us |")
    print("|---|---|---|---|---|")
    for gait in ("tripod", "metachronal"):
        exact = walk(gait, REFERENCE)
        way_mm = 1e3 * float(np.linalg.norm(exact.place[-1, :2]))
        for way in WAYS:
            found = walk(gait, way)
            off_mm = 1e3 * float(np.linalg.norm(found.place - exact.place, axis=1).max())
            force_n = float(np.sqrt(np.mean((found.force - exact.force) ** 2)))
            print(
                f"| {gait}, {way_mm:.0f} mm | {way.label} | {off_mm:.2f} mm | {force_n:.2f} N "
                f"| {found.cost_us:.0f} |"
            )


if __name__ == "__main__":
    main()
