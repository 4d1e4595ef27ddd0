"""Virtual walks for the odometry benchmark: plants whose legs differ from what the robot file says.

Each seed draws its own friction and stiffness for every leg (a log-uniform factor up to SPREAD either
way) beside its own sensor noise, so that the estimator, which is given the robot file's values, has
something to find out. The bus and its bytes are left out, as ``bigant sim run --fast`` does, and the
estimator is not run while walking: neither changes what is recorded (``--check`` walks both ways and
compares every array). Walks are kept as logs in a folder.

``python -m benchmarks.odometry_walks FOLDER`` makes them all.
"""

import argparse
import re
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

import numpy as np

from model.values.arrays import FloatArray
from model.values.faults import Fault, StopReason
from model.values.tick import Mode
from record.log.reader import read_log
from record.log.recording import Recording
from record.log.writer import LogWriter
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.control.controller import Controller
from robot.control.safety import Allowed
from robot.run.hardware import open_twin
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.run.rig import Rig, Seen
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_twin
from robot.virtual.walk import walk_in_memory
from sim_hw.clock import VirtualClock
from sim_hw.host.virtual_robot import VirtualRobot

SPREAD = 0.25
CYCLES = 9.0  # half a metre in the slipping gait
TUNING_SEEDS = tuple(range(900, 903))
JUDGED_SEEDS = tuple(range(10))
GAITS = ("tripod", "metachronal")
TEXTS = ("names", "faults", "config_text", "metadata", "damage")
ANSWERS = (
    "predicted_",
    "dead_reckoning_",
    "estimate_",
    "busy_s",
)  # what the loop makes of its inputs


def plant_of(seed: int) -> tuple[FloatArray, FloatArray]:
    """True stiffness [N/m] and friction coefficient of each leg in this seed's plant."""
    contact = load_robot().parameters.contact
    draw = np.random.default_rng(seed)
    factor = np.exp(draw.uniform(-1, 1, (2, len(contact.mu))) * np.log(1 + SPREAD))
    return contact.stiffness * factor[0], contact.mu * factor[1]


def plant_config(seed: int) -> RobotConfig:
    """The robot file with this seed's stiffness and friction written into it."""
    stiffness, mu = plant_of(seed)
    text = load_robot().text
    for key, values in (("stiffness", stiffness), ("mu", mu)):
        row = ", ".join(f"{value:.5f}" for value in values)
        text, count = re.subn(rf"(?m)^{key} = \[.*?\]", f"{key} = [{row}]", text)
        if count != 1:
            raise ValueError(f"{key} stands {count} times in the robot file")
    return parse_robot(text)


class _Reached:
    """What the loop needs of a rig, without the bytes of the bus."""

    def __init__(self, config: RobotConfig, rig: Rig, robot: VirtualRobot) -> None:
        self._rig, self._robot = rig, robot
        self._direct = DirectRobot(config, rig, robot)
        assert isinstance(rig.clock, VirtualClock)
        self.clock = rig.clock

    @property
    def torque(self) -> bool:
        return self._rig.torque

    def read(self) -> Seen:
        servos, forces = self._direct.read()
        return Seen(servos, forces, self._robot.world.truth(self.clock.now_ns()), ())

    def actuate(self, allowed: Allowed) -> tuple[Fault, ...]:
        self._direct.actuate(allowed)
        return ()

    def cut_torque(self) -> bool:
        return self._rig.cut_torque()


def walk_without_bytes(
    config: RobotConfig, gait: str, cycles: float, seed: int, path: Path
) -> None:
    """Log what ``robot.virtual.walk`` records, without its bytes and without the estimator's answers."""
    rig, robot = open_twin(
        config, file_twin(config, seed), seed=seed, armed=True, with_forces=True, cameras=False
    )
    start_ns = rig.clock.now_ns()
    quiet = replace(config, estimator=replace(config.estimator, enabled=False))
    controller = Controller(quiet, rig.calibrations, armed=True)
    script = Script(gait, controller.book.gaits[gait].frequency_hz, 0.0, cycles, None)
    writer = LogWriter(
        path, names=config.parameters.legs.names, config_text=config.text,
        metadata={"gait": gait, "hardware": "virtual"}, start_ns=start_ns, start_unix_ns=start_ns,
    )  # fmt: skip
    reached = cast(Rig, _Reached(config, rig, robot))
    result = run(reached, controller, ScriptedOperator(script, Interrupts()), writer, None)
    writer.close()
    if result.reason is not StopReason.COMPLETED:
        path.unlink()
        raise SystemExit(f"{gait} {seed} stopped early ({result.reason.name}): {result.detail}")


def check(gait: str, seed: int, cycles: float) -> list[str]:
    """Names of the arrays in which a walk without bytes differs from one with them.

    What the loop predicted and estimated meanwhile is left out: judging does that anew.
    """
    config = plant_config(seed)
    with TemporaryDirectory() as folder:
        quick = read_log(walk(gait, seed, Path(folder), cycles))
    whole = walk_in_memory(config, gait, cycles=cycles, seed=seed, progress=lambda _: None)
    walking = [int((made.mode == Mode.WALK.value).sum()) for made in (quick, whole)]
    print(f"{gait} {seed}: ticks {len(quick.t_s)} and {len(whole.t_s)}, walking {walking}")
    different = []
    for field in fields(Recording):
        if field.name in TEXTS or field.name.startswith(ANSWERS):
            continue
        one, other = getattr(quick, field.name), getattr(whole, field.name)
        if one.shape != other.shape or not np.array_equal(one, other, equal_nan=True):
            different.append(field.name)
    return different


def log_of(folder: Path, gait: str, seed: int, cycles: float = CYCLES) -> Path:
    """Where the log of a walk is kept."""
    return folder / f"{gait}_{seed}_{cycles:g}.mcap"


def walk(gait: str, seed: int, folder: Path, cycles: float = CYCLES) -> Path:
    """The log of a walk of this seed's plant, made if it is not there yet."""
    kept = log_of(folder, gait, seed, cycles)
    if not kept.exists():
        folder.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part")
        walk_without_bytes(plant_config(seed), gait, cycles, seed, part)
        part.replace(kept)
    return kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("seeds", type=int, nargs="*")
    parser.add_argument("--check", action="store_true", help="one cycle both ways, compared")
    options = parser.parse_args()
    folder: Path = options.folder
    if options.check:
        for gait in GAITS:
            print(f"different: {', '.join(check(gait, TUNING_SEEDS[0], 1.0)) or 'nothing'}")
        return
    every = (*TUNING_SEEDS[:2], *JUDGED_SEEDS, *TUNING_SEEDS[2:])
    for seed in tuple(options.seeds) or every:
        for gait in GAITS:
            print(f"{gait} {seed}: {walk(gait, seed, folder)}", flush=True)


if __name__ == "__main__":
    main()
