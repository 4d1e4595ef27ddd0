"""Virtual walks for the odometry benchmark: plants whose legs differ from what the robot file says.

Each seed draws its own friction and stiffness for every leg (a log-uniform factor up to SPREAD either
way) beside its own sensor noise, so that the estimator, which is given the robot file's values, has
something to find out. The bus and its bytes are left out, as ``bigant sim run --fast`` does, and the
estimator is not run while walking: neither changes what is recorded (``--check`` walks both ways and
compares every array). Walks are kept as logs in a folder.

``python -m benchmarks.odometry.walks FOLDER`` makes them all.
"""

import argparse
import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from model.values.arrays import FloatArray
from model.values.tick import Mode
from record.log.blocks.read import read_log
from record.log.recording import Recording
from record.log.writer import LogWriter
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.control.controller import Controller
from robot.run.operator import Script
from robot.run.rig import Reading
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_twin
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.rehearsal import rehearse
from robot.virtual.walk import walk_in_memory
from sim_hw.assumed import ImuAssumed
from sim_hw.twin.twin import Twin

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


class _WithTruth(DirectRobot):
    """The robot without the bytes of the bus, with ground truth."""

    def read(self) -> Reading:
        return replace(super().read(), truth=self.world.truth(self.clock.now_ns()))


def walk_without_bytes(
    config: RobotConfig,
    gait: str,
    cycles: float,
    seed: int,
    path: Path,
    twin: Twin | None = None,
    imu: ImuAssumed | None = None,
) -> None:
    """Log what ``robot.virtual.walk`` records, without its bytes and without the estimator's answers.

    The robot that is there is that of the robot file, or a ``twin``; it has an ``imu`` if one is given.
    """
    twin = twin if twin is not None else file_twin(config, seed)
    rig, robot = open_twin(config, twin, VirtualSettings(seed=seed, imu=imu), cameras=False)
    start_ns = rig.clock.now_ns()
    quiet = replace(config, estimator=replace(config.estimator, enabled=False))
    controller = Controller(quiet, rig.calibrations, armed=True)
    script = Script(gait, controller.book.gaits[gait].frequency_hz, cycles=cycles)
    writer = LogWriter(
        path, names=config.parameters.legs.names, config_text=config.text,
        metadata={"gait": gait, "hardware": "virtual"}, start_ns=start_ns, start_unix_ns=start_ns,
    )  # fmt: skip
    rehearse(_WithTruth(config, rig, robot), controller, script, lambda _: None, writer)
    writer.close()


def check(gait: str, seed: int, cycles: float) -> list[str]:
    """Names of the arrays in which a walk without bytes differs from one with them.

    What the loop predicted and estimated meanwhile is left out: judging does that again.
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


def kept_log(kept: Path, make: Callable[[Path], None]) -> Path:
    """Return a log, made if it is not there yet: one that is cut short while it is made is not kept."""
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part")
        make(part)
        part.replace(kept)
    return kept


def walk(gait: str, seed: int, folder: Path, cycles: float = CYCLES) -> Path:
    """The log of a walk of this seed's plant, made if it is not there yet."""
    return kept_log(
        log_of(folder, gait, seed, cycles),
        lambda path: walk_without_bytes(plant_config(seed), gait, cycles, seed, path),
    )


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
