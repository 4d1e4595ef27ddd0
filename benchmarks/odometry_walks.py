"""Virtual walks for the odometry benchmark: plants whose legs differ from what the robot file says.

Each seed draws its own friction and stiffness for every leg (a log-uniform factor up to SPREAD either
way) beside its own sensor noise, so that the estimator, which is given the robot file's values, has
something to find out. Walks are kept as arrays in a folder, because making one takes as long as walking it.

``python -m benchmarks.odometry_walks FOLDER`` makes them all.
"""

import argparse
import re
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType

import numpy as np

from model.signals import FloatArray
from record.recording import Recording
from robot.config import RobotConfig, load_robot, parse_robot
from robot.virtual_walk import walk_in_memory

SPREAD = 0.25
CYCLES = 9.0  # half a metre in the slipping gait
TUNING_SEEDS = tuple(range(900, 903))
JUDGED_SEEDS = tuple(range(10))
GAITS = ("tripod", "metachronal")
TEXTS = ("names", "faults", "config_text", "metadata", "damage")


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


def walk(gait: str, seed: int, folder: Path, cycles: float = CYCLES) -> Recording:
    """A walk of this seed's plant, from the folder if it has been made before."""
    kept = folder / f"{gait}_{seed}_{cycles:g}.npz"
    if kept.exists():
        return _load(kept)
    made = walk_in_memory(
        plant_config(seed), gait, cycles=cycles, seed=seed, progress=lambda _: None
    )
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
    folder: Path = parser.parse_args().folder
    for seed in (*TUNING_SEEDS[:2], *JUDGED_SEEDS, *TUNING_SEEDS[2:]):
        for gait in GAITS:
            made = walk(gait, seed, folder)
            print(f"{gait} {seed}: {made.t_s[-1]:.0f} s", flush=True)


if __name__ == "__main__":
    main()
