"""Virtual walks for the odometry benchmark: plants whose legs differ from what the robot file says.

Each seed draws its own friction and stiffness for every leg (a log-uniform factor up to SPREAD either
way) beside its own sensor noise, so that the estimator, which is given the robot file's values, has
something to find out. The bus and its bytes are left out, as ``bigant sim run --fast`` does, and the
estimator is not run while walking: neither changes what is recorded (``--check`` walks both ways and
compares every array). Walks are kept as arrays in a folder.

``python -m benchmarks.odometry_walks FOLDER`` makes them all.
"""

import argparse
import re
from dataclasses import fields, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from model.values.arrays import FloatArray
from model.values.tick import Mode
from record.log.recording import Recording, build_recording
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.control.controller import Controller
from robot.run.operator import Script
from robot.run.rig import Reading
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_twin
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.rehearsal import rehearse
from robot.virtual.walk import TickList, walk_in_memory

SPREAD = 0.25
CYCLES = 9.0  # half a metre in the slipping gait
TUNING_SEEDS = tuple(range(900, 903))
JUDGED_SEEDS = tuple(range(10))
GAITS = ("tripod", "metachronal")
TEXTS = ("names", "faults", "config_text", "metadata", "damage")
ANSWERS = ("predicted_", "estimate_", "odometry_", "busy_s")  # what the loop makes of its inputs


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


def walk_without_bytes(config: RobotConfig, gait: str, cycles: float, seed: int) -> Recording:
    """What ``robot.virtual.walk`` records, without its bytes and without the estimator's answers."""
    rig, robot = open_twin(
        config, file_twin(config, seed), VirtualSettings(seed=seed), cameras=False
    )
    start_ns = rig.clock.now_ns()
    quiet = replace(config, estimator=replace(config.estimator, enabled=False))
    controller = Controller(quiet, rig.calibrations, armed=True)
    script = Script(gait, controller.book.gaits[gait].frequency_hz, cycles=cycles)
    kept = TickList()
    rehearse(_WithTruth(config, rig, robot), controller, script, lambda _: None, kept)
    return build_recording(
        kept.ticks, names=config.parameters.legs.names, start_ns=start_ns,
        config_text=config.text, metadata=MappingProxyType({"gait": gait}), damage="",
    )  # fmt: skip


def check(gait: str, seed: int, cycles: float) -> list[str]:
    """Names of the arrays in which a walk without bytes differs from one with them.

    What the loop predicted and estimated meanwhile is left out: judging does that anew.
    """
    config = plant_config(seed)
    quick = walk_without_bytes(config, gait, cycles, seed)
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


def walk(gait: str, seed: int, folder: Path, cycles: float = CYCLES) -> Recording:
    """A walk of this seed's plant, from the folder if it has been made before."""
    kept = folder / f"{gait}_{seed}_{cycles:g}.npz"
    if kept.exists():
        return _load(kept)
    made = walk_without_bytes(plant_config(seed), gait, cycles, seed)
    arrays = {f.name: getattr(made, f.name) for f in fields(Recording) if f.name not in TEXTS}
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(
        kept, **arrays, names=np.array(made.names), gait=made.metadata["gait"],
        config_text=made.config_text,
    )  # fmt: skip
    return _load(kept)


def _load(path: Path) -> Recording:
    with np.load(path) as kept:
        absent = np.full(1, np.nan)  # walks kept from before the estimator ran in the loop
        arrays = {
            f.name: kept.get(f.name, absent) for f in fields(Recording) if f.name not in TEXTS
        }
        return Recording(
            **arrays,
            names=tuple(str(name) for name in kept["names"]),
            faults=(),
            config_text=str(kept["config_text"]),
            metadata=MappingProxyType({"gait": str(kept["gait"]), "hardware": "virtual"}),
            damage="",
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
            made = walk(gait, seed, folder)
            print(f"{gait} {seed}: {made.t_s[-1]:.0f} s", flush=True)


if __name__ == "__main__":
    main()
