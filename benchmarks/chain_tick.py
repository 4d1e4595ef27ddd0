"""A tick of a robot whose legs have several joints: kinematics, model and estimator, without a controller.

It prints medians over the ticks of a made-up motion of each example robot that has chains, and of BigANT's
four-bars beside them. Results are written up in docs/performance.md.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.timing import each
from drivers.ati.foot_forces import no_forces
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frame import prepare, solve_frame
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import JointState
from robot.config.robot_file import RobotConfig, load_robot
from robot.control.estimator_stage import estimator_stage

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CHAINS = ("quadruped12", "hexapod18")
TICKS, RATE_HZ = 500, 100
FIRST = 20  # ticks before the filter knows where it is


def joint_states(config: RobotConfig) -> list[JointState]:
    """Joints that swing a little about where the robot stands."""
    names = config.parameters.names
    count = len(names.joints)
    stand = np.tile([0.0, 0.9, -1.8], 4) if len(names.legs) == 4 else np.zeros(count)
    time_s, phase = np.arange(TICKS) / RATE_HZ, np.linspace(0, 2 * np.pi, count)
    unknown, known = np.full(count, np.nan), np.ones(count, dtype=bool)
    whole = JointState(0, unknown, unknown, unknown, unknown, unknown, unknown, known)

    def at(t_s: float) -> JointState:
        angle, rate = 0.1 * np.sin(2 * t_s + phase), 0.2 * np.cos(2 * t_s + phase)
        return replace(whole, t_ns=round(t_s * 1e9), angle_rad=stand + angle, rate_rad_s=rate)

    return [at(t_s) for t_s in time_s.tolist()]


def measure(config: RobotConfig) -> tuple[float, ...]:
    """Return medians of kinematics, Jacobian, model, and all of a tick with the estimator [us]."""
    robot = config.parameters
    legs, weight_n = leg_kinematics(robot), robot.body.mass * STANDARD_GRAVITY
    stage, silent = estimator_stage(config, legs), no_forces(robot.legs.count)
    prepare()
    states, memory = joint_states(config), stage.initial()
    feet = [legs.feet(one.angle_rad, one.rate_rad_s) for one in states]

    def tick(joints: JointState) -> None:
        nonlocal memory
        motion = legs.feet(joints.angle_rad, joints.rate_rad_s)
        solve_frame(motion, robot.contact, weight_n)
        memory, _ = stage.step(memory, joints.t_ns, joints, silent, ())

    for joints in states[:FIRST]:
        tick(joints)
    angles: list[FloatArray] = [one.angle_rad for one in states]
    return (
        each([partial(legs.feet, one.angle_rad, one.rate_rad_s) for one in states]).median,
        each([partial(legs.jacobian, angle) for angle in angles]).median,
        each([partial(solve_frame, one, robot.contact, weight_n) for one in feet]).median,
        each([partial(tick, joints) for joints in states[FIRST:]], rounds=1).median,
    )


def main() -> None:
    print("robot        joints  feet [us]  Jacobian [us]  model [us]  a tick, estimator too [us]")
    chains = (load_robot(EXAMPLES / f"{name}.toml", driven=False) for name in CHAINS)
    for config in (load_robot(), *chains):
        feet, jacobian, model, tick = measure(config)
        joints = len(config.parameters.names.joints)
        print(
            f"{config.name:<12} {joints:>6} {feet:>10.1f} {jacobian:>14.1f} {model:>11.1f} {tick:>10.1f}"
        )


if __name__ == "__main__":
    main()
