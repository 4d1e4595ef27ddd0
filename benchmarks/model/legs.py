"""Run time against number of legs: our model, batched, and MuJoCo's step of the same disk."""

import time
from dataclasses import asdict
from functools import partial

import mujoco
import numpy as np

from benchmarks.timing import Spread, each, keep, spread
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.systems.disk import disk, random_disk_poses

LEGS = (3, 6, 12, 24, 50)
POSES = 1000
ROUNDS = 101


def disk_mjcf(legs: int) -> str:
    """A disk on a plane; each leg two rotations and a vertical slide, servo-held, a ball for a foot."""
    limbs = []
    motors = []
    for k in range(legs):
        angle = 2 * np.pi * k / legs
        x, y = 0.3 * np.cos(angle), 0.3 * np.sin(angle)
        limbs.append(
            f'<body pos="{x:.5f} {y:.5f} 0" euler="0 0 {np.degrees(angle):.4f}">'
            f'<joint name="y{k}" type="hinge" axis="0 0 1" range="-3 3" damping="0.1"/>'
            f'<joint name="p{k}" type="hinge" axis="0 1 0" range="-10 10" damping="0.1"/>'
            f'<joint name="s{k}" type="slide" axis="0 0 1" range="-0.02 0.02" damping="5"/>'
            '<geom type="capsule" fromto="0 0 0 0.05 0 -0.14" size="0.006" mass="0.02" '
            'contype="0" conaffinity="0"/>'
            '<geom type="sphere" pos="0.05 0 -0.14" size="0.01" mass="0.02" '
            'contype="1" conaffinity="2" friction="0.6"/></body>'
        )
        motors += [
            f'<position joint="{name}{k}" kp="{gain}"/>'
            for name, gain in (("y", 20), ("p", 20), ("s", 500))
        ]
    return (
        "<mujoco><compiler angle='degree'/><option timestep='0.002'/>"
        "<worldbody><geom type='plane' size='5 5 0.1' contype='2' conaffinity='1' friction='0.6'/>"
        "<body pos='0 0 0.15'><freejoint/><geom type='cylinder' size='0.3 0.01' mass='4' "
        f"contype='0' conaffinity='0'/>{''.join(limbs)}</body></worldbody>"
        f"<actuator>{''.join(motors)}</actuator></mujoco>"
    )


def _mujoco(legs: int, rng: np.random.Generator) -> Spread:
    model = mujoco.MjModel.from_xml_string(disk_mjcf(legs))
    states = []
    for _ in range(POSES):
        data = mujoco.MjData(model)
        low, high = model.jnt_range[1:].T
        data.qpos[7:] = rng.uniform(low, high)
        data.qvel[6:] = rng.normal(scale=0.1, size=model.nv - 6)
        data.qpos[2] = 0.15
        mujoco.mj_forward(model, data)
        states.append((data.qpos.copy(), data.qvel.copy()))
    data = mujoco.MjData(model)

    def step(state: tuple[np.ndarray, np.ndarray]) -> None:
        data.qpos[:], data.qvel[:] = state
        mujoco.mj_step(model, data)

    return each([partial(step, state) for state in states], 2)


def main() -> None:
    """Print the table and keep it for the figure."""
    rng = np.random.default_rng(0)
    cases = [(disk(legs), random_disk_poses(POSES, legs, rng)) for legs in LEGS]
    laws = (FrictionLaw.VISCOUS, FrictionLaw.COULOMB)
    samples = {law: [[] for _ in LEGS] for law in laws}  # type: dict[FrictionLaw, list[list[float]]]
    for turn in range(ROUNDS + 1):  # all cases in turn, so that all see the same machine
        for law in laws:
            for i, (system, feet) in enumerate(cases):
                began = time.perf_counter_ns()
                solve_frames(feet, system.contact, system.weight_n, law=law)
                if turn:
                    samples[law][i].append((time.perf_counter_ns() - began) / 1e3 / POSES)
    ours, coulomb = ([spread(row) for row in samples[law]] for law in laws)
    theirs = [_mujoco(legs, rng) for legs in LEGS]
    print("legs   ours, batched [us]   Coulomb, batched [us]   MuJoCo mj_step [us]   MuJoCo / ours")
    for i, legs in enumerate(LEGS):
        ratio = theirs[i].median / ours[i].median
        print(
            f"{legs:4d}{ours[i].median:16.2f}{coulomb[i].median:24.2f}{theirs[i].median:22.1f}"
            f"{ratio:16.0f}"
        )
    for name, figures in (("ours", ours), ("Coulomb", coulomb), ("MuJoCo", theirs)):
        print(
            f"{name}: {LEGS[-1]} legs cost {figures[-1].median / figures[0].median:.1f} x {LEGS[0]}"
        )
    keep(
        legs=list(LEGS),
        ours_us=_columns(ours),
        coulomb_us=_columns(coulomb),
        mujoco_us=_columns(theirs),
    )


def _columns(rows: list[Spread]) -> dict[str, list[float]]:
    return {key: [round(asdict(row)[key], 4) for row in rows] for key in asdict(rows[0])}


if __name__ == "__main__":
    main()
