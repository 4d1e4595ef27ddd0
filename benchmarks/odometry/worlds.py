"""Virtual walks in worlds that differ from the robot file in many ways at once, for the odometry's bars.

Each seed draws a world: stiffness and friction of every leg, law of friction, lengths and zeros of the
legs, centre of mass, slope of the ground, delay of the forces, and in some worlds an encoder that dies on
the way. The estimator is given the robot file. Walks are kept as logs in a folder, as
``benchmarks.odometry.walks`` makes them; ``benchmarks.odometry.bars`` judges them.

``python -m benchmarks.odometry.worlds FOLDER`` makes them all; ``--realities`` makes walks of healthy
robots that are built differently (``bigant sim realities``), which nothing was tuned on.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.odometry.walks import GAITS, kept_log, walk_without_bytes
from model.kinematics.legs import leg_kinematics
from robot.config.robot_file import RobotConfig, load_robot
from robot.virtual.file_twin import nominal_twin
from robot.virtual.reality_robot import robot_in
from sim_hw.assumed import ImuAssumed
from sim_hw.realities.catalogue import REALITIES, find_reality
from sim_hw.realities.reality import real_twin
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import TwinEffect, apply_effects
from sim_hw.twin.twin import Twin

CONTACT_SHARE = 0.25  # of a leg's stiffness and friction, either way
LENGTH_SHARE = 0.02  # of a leg's length
ZERO_RAD = np.radians(2.0)
COM_M = 0.015
SLOPE = np.tan(np.radians(3.0))
DELAY_S = 0.02
STATIC_RATIO = 1.4
ANISOTROPY = 0.3
CYCLES = 4.0
DEAD_EVERY = 6  # one world in so many loses an encoder
TUNING_SEEDS = tuple(range(700, 724))
JUDGED_SEEDS = tuple(range(300, 364))
REALITY_SEEDS = (400,)


@dataclass(frozen=True, slots=True)
class World:
    """What one seed draws.

    Attributes:
        seed: The seed.
        gait: What is walked in it.
        effects: How the robot and its ground differ from the robot file.
        dead_leg: Leg whose encoder dies, -1 for none.
        dead_share: When it dies, as share of the walk.
        reality: How the robot is built, as ``bigant sim realities`` names it; empty for the usual twin.
    """

    seed: int
    gait: str
    effects: tuple[TwinEffect, ...]
    dead_leg: int
    dead_share: float
    reality: str = ""

    @property
    def name(self) -> str:
        """Of its log."""
        return f"{self.reality}_{self.gait}_{self.seed}" if self.reality else f"world_{self.seed}"


def world_of(seed: int, config: RobotConfig) -> World:
    """Return the world of a seed: the gaits take turns."""
    draw = np.random.default_rng([seed, 20])
    names = config.parameters.legs.names
    count = len(names)
    feet = leg_kinematics(config.parameters).feet(np.zeros(count), np.zeros(count))
    length_m = float(-feet.position_m[:, 2].mean())
    ratio = np.exp(draw.uniform(-1, 1, (2, count)) * np.log(1 + CONTACT_SHARE))
    effects = [
        TwinEffect(name, leg, (float(value),))
        for name, values in (
            ("leg_stiffness", ratio[0]),
            ("foot_friction", ratio[1]),
            ("leg_length", draw.uniform(-1, 1, count) * LENGTH_SHARE * length_m),
            ("shaft_zero_offset", draw.uniform(-1, 1, count) * ZERO_RAD),
        )
        for leg, value in zip(names, values, strict=True)
    ]
    x, y = draw.uniform(-1, 1, 2) * COM_M
    effects.append(TwinEffect("com_offset", "", (float(x), float(y))))
    steep, way = SLOPE * np.sqrt(draw.uniform()), draw.uniform(0, 2 * np.pi)
    slope = (float(steep * np.cos(way)), float(steep * np.sin(way)))
    effects.append(TwinEffect("ground_slope", "", slope))
    effects.append(TwinEffect("force_delay", "", (float(draw.uniform(0, DELAY_S)),)))
    law = draw.integers(3)
    if law == 1:
        effects.append(TwinEffect("stiction", "", (float(draw.uniform(1, STATIC_RATIO)), 0.005)))
    elif law == 2:
        w = draw.uniform(-ANISOTROPY, ANISOTROPY, 2)
        effects.append(TwinEffect("friction_anisotropy", "", (float(w[0]), float(w[1]))))
    dead = int(draw.integers(count)) if seed % DEAD_EVERY == DEAD_EVERY - 1 else -1
    return World(seed, GAITS[seed % 2], tuple(effects), dead, float(draw.uniform(0.3, 0.7)))


def reality_worlds(seeds: Sequence[int]) -> Iterator[World]:
    """Return a healthy robot in each reality, walking both gaits, on the day of each seed."""
    for one in REALITIES:
        for gait in GAITS:
            for seed in seeds:
                yield World(seed, gait, (), -1, 1.0, one.name)


def config_of(world: World) -> RobotConfig:
    """Return the robot file that the estimator is given."""
    config = load_robot()
    return robot_in(find_reality(world.reality), config) if world.reality else config


def twin_of(world: World, config: RobotConfig) -> Twin:
    """Return the robot that is really there."""
    if world.reality:
        return real_twin(find_reality(world.reality), config.parameters, world.seed)
    return apply_effects(nominal_twin(config, world.seed), world.effects, EFFECTS)


def imu_of(seed: int) -> ImuAssumed:
    """Return the yaw gyro of a world: its bias and noise are those of small MEMS units."""
    bias = float(np.random.default_rng([seed, 21]).normal(0.0, 0.005))
    return ImuAssumed(yaw_rate_bias_rad_s=bias, yaw_rate_noise_rad_s=0.004, tilt=False)


def world_log(folder: Path, world: World) -> Path:
    """Return the log of a world's walk, made if it is not there yet."""

    def make(path: Path) -> None:
        config = config_of(world)
        walk_without_bytes(
            config, world.gait, CYCLES, world.seed, path,
            twin=twin_of(world, config), imu=imu_of(world.seed),
        )  # fmt: skip

    return kept_log(folder / f"{world.name}.mcap", make)


def worlds_of(seeds: Sequence[int], *, realities: bool, default: Sequence[int]) -> list[World]:
    """Return the worlds that a command line asks for."""
    if realities:
        return list(reality_worlds(seeds or REALITY_SEEDS))
    config = load_robot()
    return [world_of(seed, config) for seed in seeds or default]


def main() -> None:
    """Make the walks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("seeds", type=int, nargs="*")
    parser.add_argument(
        "--realities", action="store_true", help="robots that are built differently"
    )
    options = parser.parse_args()
    default = (*TUNING_SEEDS, *JUDGED_SEEDS)
    for world in worlds_of(options.seeds, realities=options.realities, default=default):
        print(world_log(options.folder, world), flush=True)


if __name__ == "__main__":
    main()
