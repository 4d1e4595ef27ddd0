"""Predictions of an MJCF machine in one call against a Python loop over mj_step, in the same run.

``python -m benchmarks.gap.mjcf_rollouts [go2_fixed_base.xml]``: four sizes of friction at each joint of a
quadruped with a fixed base (the file of ``docs/real/go2.md``, or one like it made here), each simulated for
eight seconds. The loop does what one would write: for each candidate, for each step, set the
targets, ``mj_step``, and keep the angles of every frame. Medians of rounds in turn, and the
shortest of each, which other programs on the machine disturbed least.
"""

import statistics
import sys
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from gap.interfaces import Cause, Drive
from gap.machines.mujoco.machine import MjcfMachine, make_machine
from gap.machines.mujoco.rollouts import THREADS
from model.values.arrays import FloatArray
from record.trial.header import TrialHeader
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

LEGS, PARTS = ("FL", "FR", "RL", "RR"), ("hip", "thigh", "calf")
JOINTS = tuple(f"{leg}_{part}" for leg in LEGS for part in PARTS)
LOOP = 'kind = "position"\nkp_nm_rad = 20.0\nkd_nm_s_rad = 1.5\n'
SECONDS, HZ, ROUNDS, SIZES = 8.0, 100.0, 9, 4
STEP_S = 0.0025  # of both


def quadruped() -> str:
    """An MJCF of four legs of three joints on a fixed base."""
    legs = "".join(
        f'<body name="{leg}_hip" pos="{x} {y} 0.5"><joint name="{leg}_hip_joint" axis="1 0 0"/>'
        '<inertial pos="0 0 0" mass="0.7" diaginertia="0.0009 0.0006 0.0005"/>'
        f'<body name="{leg}_thigh" pos="0 {y} 0"><joint name="{leg}_thigh_joint" axis="0 1 0"/>'
        '<inertial pos="0 0 -0.03" mass="1.1" diaginertia="0.006 0.006 0.0009"/>'
        f'<body name="{leg}_calf" pos="0 0 -0.21"><joint name="{leg}_calf_joint" axis="0 1 0"/>'
        '<inertial pos="0 0 -0.12" mass="0.3" diaginertia="0.002 0.002 0.0001"/></body></body></body>'
        for leg, x, y in zip(LEGS, (0.2, 0.2, -0.2, -0.2), (0.05, -0.05, 0.05, -0.05), strict=True)
    )
    return f'<mujoco model="quadruped"><worldbody>{legs}</worldbody></mujoco>'


def log_of(xml: str) -> Trial:
    """A log in which every joint swings; what it reads does not matter here."""
    t = np.arange(round(SECONDS * HZ)) / HZ
    header = TrialHeader("mjcf", JOINTS, robot_file="robot.xml", robot_text=xml, drive=LOOP)
    columns = [TableColumn("time_s", t)]
    for at, joint in enumerate(JOINTS):
        middle = -1.5 if joint.endswith("calf") else 0.3
        command = middle + 0.3 * np.sin(2 * np.pi * (0.5 + 0.05 * at) * t)
        columns += [TableColumn(f"{what}_{joint}_rad", command) for what in ("command", "shaft")]
    return build_trial(header, columns)


def by_hand(machine: MjcfMachine, trial: Trial, frictions: FloatArray) -> list[FloatArray]:
    """Step each candidate in a loop; (F, J) each."""
    rigid: Any = machine.parts.rigid
    spec = mujoco.MjSpec.from_string(trial.header.robot_text)
    for name in rigid.in_file:
        loop = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        loop.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    every = round(1.0 / HZ / STEP_S)
    early, step_s = trial.shaft_rad[:3], 1.0 / HZ
    speed = (-1.5 * early[0] + 2.0 * early[1] - 0.5 * early[2]) / step_s
    made = []
    for number, friction in enumerate(frictions):
        at = number % len(JOINTS)
        data = mujoco.MjData(model)
        dry = model.dof_frictionloss.copy()
        model.dof_frictionloss[rigid.speed[at]] += friction
        model.opt.timestep = STEP_S
        model.actuator_gainprm[:, 0], model.actuator_biasprm[:, 1:3] = 20.0, (-20.0, -1.5)
        data.qpos[rigid.position] = trial.shaft_rad[0]
        data.qvel[rigid.speed] = speed
        out = np.empty((len(trial.time_s), len(JOINTS)))
        for row, command in enumerate(trial.command_rad):
            out[row] = data.qpos[rigid.position]
            for _ in range(every):
                data.ctrl[:] = command
                mujoco.mj_step(model, data)
        model.dof_frictionloss[:] = dry
        made.append(out - trial.command_rad)
    return made


def at_once(machine: MjcfMachine, trial: Trial, frictions: FloatArray) -> list[FloatArray]:
    """Predict all candidates in one call, nothing of which is remembered."""
    causes = [
        (Cause("coulomb_friction", (joint,), (float(value),)),)
        for joint, value in zip(JOINTS * SIZES, frictions, strict=True)
    ]
    return machine.predict_many([(trial, one, Drive.COMMAND) for one in causes])


def main(path: str = "") -> None:
    """Print the medians and their ratio."""
    trial = log_of(Path(path).read_text(encoding="utf-8") if path else quadruped())
    machine = make_machine([trial])
    machine.predict(trial, (), Drive.COMMAND)
    spent: dict[str, list[float]] = {"loop": [], "batch": [], "loop cpu": [], "batch cpu": []}
    worst = 0.0
    for number in range(ROUNDS):
        frictions = np.linspace(0.1, 0.6, SIZES * len(JOINTS)) + 0.001 * number
        predicted = []
        for kind, make in (("batch", at_once), ("loop", by_hand)):
            began, busy = time.perf_counter(), time.process_time()
            predicted.append(make(machine, trial, frictions))
            spent[kind].append(time.perf_counter() - began)
            spent[f"{kind} cpu"].append(time.process_time() - busy)
        worst = max(worst, *(float(np.abs(a - b).max()) for a, b in zip(*predicted, strict=True)))
    count, steps = SIZES * len(JOINTS), SECONDS / STEP_S
    print(
        f"{count} candidates of {SECONDS:g} s, {steps:.0f} steps each; largest difference {worst:.1e} rad"
    )
    for words, kind in (
        ("Python loop over mj_step", "loop"),
        ("one call of predict_many", "batch"),
    ):
        wall, busy = (statistics.median(spent[f"{kind}{end}"]) for end in ("", " cpu"))
        each = 1e6 * wall / count / steps
        print(f"{words}   {wall:.3f} s, {busy:.3f} s of processors, {each:.2f} us a step")
    wall, busy = (
        statistics.median(spent[f"loop{end}"]) / statistics.median(spent[f"batch{end}"])
        for end in ("", " cpu")
    )
    print(f"ratio of the medians       {wall:.1f}; of processor time {busy:.1f}, {THREADS} threads")
    print(f"ratio of the shortest      {min(spent['loop']) / min(spent['batch']):.1f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
