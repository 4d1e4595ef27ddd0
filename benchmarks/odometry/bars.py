"""How far an estimate can be trusted, over worlds that differ from the robot file in many ways at once.

``python -m benchmarks.odometry.bars FOLDER`` judges the walks of ``benchmarks.odometry.worlds``, each with
and without forces and with and without a yaw gyro; an encoder that dies in a world is dead in all four.
``--realities`` judges healthy robots that are built differently, each in a row of its own. ``--faults``
makes walks with one large fault each and prints what is noticed.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing import Pool
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.stats import chi2

from benchmarks.odometry.walks import GAITS, walk_without_bytes
from benchmarks.odometry.worlds import (
    JUDGED_SEEDS,
    World,
    config_of,
    imu_of,
    world_log,
    worlds_of,
)
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import SOURCES, Health
from record.log.blocks.read import read_log
from record.log.reader import StampedTick, read_stamped_ticks
from robot.config.robot_file import load_robot
from robot.odometry.compare import compare_methods, walking_part
from robot.odometry.track import TrackedLog, Tracker
from robot.virtual.file_twin import nominal_twin
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import apply_effects, parse_effect

STRETCH = 500  # ticks, 5 s
OUTSIDE = 0.2  # share of a stretch outside the 99 % ellipse from which on it is bad
LOW, HIGH = 1.5, 6.0  # of NEES, 3 is ideal
NIS_LOW, NIS_HIGH = 0.7, 1.4
FAULTS = (
    "com_offset:x_m=0.06", "shaft_zero_offset@ML:offset_rad=0.17", "leg_length@FR:offset_m=0.012",
    "foot_friction@HL:ratio=0.15", "ground_slope:slope_x=0.052,slope_y=0", "payload:mass_kg=2,x_m=0,y_m=0",
    "force_gain@MR:ratio=1.6", "leg_stiffness@FL:ratio=0.35",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Mode:
    """What the estimator is given besides shafts."""

    forces: bool
    gyro: bool

    @property
    def name(self) -> str:
        """In words."""
        parts = [word for word, there in (("forces", self.forces), ("gyro", self.gyro)) if there]
        return " and ".join(parts) or "shafts alone"


MODES = (Mode(True, False), Mode(False, False), Mode(True, True), Mode(False, True))


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """One walk by one mode.

    Attributes:
        world: What the robot and its ground really are.
        mode: What the estimator was given.
        ok: Share of ticks called ok.
        nees: Of velocity and pose over the ticks called ok, (2,); NaN without any.
        bad: Stretches outside their ellipse too long, (S,).
        doubted: Stretches not called ok, (S,).
        dead: Stretches with a dead encoder, (S,).
        nis: By source, over its numbers, (5,); NaN without any.
        of_naive: RMSE of vx, vy, yaw rate over that of the open loop [%], (3,).
        forces_of_naive: RMSE of each foot's forces over that of the open loop [%], (N, 3).
        step_us: Median time of a step.
    """

    world: World
    mode: Mode
    ok: float
    nees: FloatArray
    bad: BoolArray
    doubted: BoolArray
    dead: BoolArray
    nis: FloatArray
    of_naive: FloatArray
    forces_of_naive: FloatArray
    step_us: float


def judge(folder: Path, world: World) -> list[Judged]:
    """Judge the walk of a world by all modes; without force sensors only by those without forces."""
    config, path = config_of(world), world_log(folder, world)
    log, items = read_log(path), list(read_stamped_ticks(path))
    span = walking_part(log)
    dies = span.stop if world.dead_leg < 0 else span.start + int(
        world.dead_share * (span.stop - span.start)
    )  # fmt: skip
    judged = []
    forces = bool(np.isfinite(log.force_n).any())
    for mode in (one for one in MODES if forces or not one.forces):
        tracker = Tracker(config, no_forces=not mode.forces, no_imu=not mode.gyro)
        for number, item in enumerate(items):
            seen = without_encoder(item, world.dead_leg) if number >= dies else item
            tracker.take(seen.unix_ns, seen.tick.sensed)
        found = compare_methods(TrackedLog(log, config, tracker.track()))
        mine, naive = found.errors[:2]
        ok = np.array([one is Health.OK for one in found.track.estimates.healths])
        with np.errstate(invalid="ignore"):
            both = [
                np.nanmean(x[ok]) if ok.any() else np.nan
                for x in (found.twist_nees, found.pose_nees)
            ]
        outside = found.twist_nees > chi2.ppf(0.99, 3)
        used = found.track.column("source_dof").sum(axis=0)
        squared = np.nansum(found.track.column("source_nis"), axis=0)
        judged.append(Judged(
            world, mode, float(ok.mean()), np.array(both),
            np.array([part.mean() > OUTSIDE for part in stretches(outside)]),
            np.array([part.mean() < 0.5 for part in stretches(ok)]),
            np.array([span.start + (k + 1) * STRETCH > dies for k in range(len(stretches(ok)))]),
            np.where(used > 0, squared / np.maximum(used, 1), np.nan),
            100 * mine.velocity_rmse / naive.velocity_rmse,
            100 * mine.force_rmse_n / naive.force_rmse_n,
            float(np.median(found.track.step_us)),
        ))  # fmt: skip
    return judged


def stretches(values: BoolArray) -> list[BoolArray]:
    """Cut into stretches; a rest shorter than one is left out."""
    count = len(values) // STRETCH
    return [values[k * STRETCH : (k + 1) * STRETCH] for k in range(count)]


def without_encoder(item: StampedTick, leg: int) -> StampedTick:
    """The tick as it would be with a dead encoder."""
    joints = item.tick.joints
    angle, rate = joints.angle_rad.copy(), joints.rate_rad_s.copy()
    angle[leg] = rate[leg] = np.nan
    dead = replace(joints, angle_rad=angle, rate_rad_s=rate)
    return replace(item, tick=replace(item.tick, joints=dead))


def lines_of(rows: Sequence[Judged]) -> Iterator[str]:
    """Sum up the walks of one gait and mode."""
    called = [one for one in rows if one.ok > 0.5] or list(rows)
    nees = np.array([one.nees for one in called])
    inside = ((nees >= LOW) & (nees <= HIGH)).mean(axis=0)
    for k, name in enumerate(("velocity", "pose")):
        yield (
            f"  NEES of {name}: median {np.median(nees[:, k]):.1f} ({nees[:, k].min():.1f}, "
            f"{nees[:, k].max():.1f}), {100 * inside[k]:.0f} % of {len(called)} walks called ok in "
            f"[{LOW}, {HIGH}]"
        )
    bad, doubted, dead = (
        np.concatenate([getattr(r, n) for r in rows]) for n in ("bad", "doubted", "dead")
    )
    live = ~dead
    good = ~bad & live
    yield (
        f"  stretches of 5 s: {bad.sum()} of {len(bad)} bad, {(bad & doubted).sum()} of them doubted; "
        f"{(good & doubted).sum()} of {good.sum()} good ones doubted; {(dead & doubted).sum()} of "
        f"{dead.sum()} with a dead encoder said so"
    )
    nis = np.array([one.nis for one in rows])
    for k, source in enumerate(SOURCES):
        known = nis[np.isfinite(nis[:, k]), k]
        if len(known):
            inside_nis = np.mean((known >= NIS_LOW) & (known <= NIS_HIGH))
            yield (
                f"  NIS of {source}: median {np.median(known):.2f} ({known.min():.2f}, "
                f"{known.max():.2f}), {100 * inside_nis:.0f} % in [{NIS_LOW}, {NIS_HIGH}]"
            )
    alive = [one for one in rows if not one.dead.any()]
    share = np.array([one.of_naive for one in alive])
    for k, name in enumerate(("vx", "vy", "yaw rate")):
        bar = 70 if k == 0 else 102
        met = 100 * (share[:, k] <= bar).mean()
        yield (
            f"  {name} RMSE, % of the open loop's: median {np.median(share[:, k]):.0f} "
            f"({share[:, k].min():.0f}, {share[:, k].max():.0f}), {met:.0f} % at most {bar}"
        )
    forces = np.array([one.forces_of_naive for one in alive])
    for k, name in enumerate(("Fx", "Fy", "Fz")):
        yield (
            f"  {name} RMSE a foot, % of the open loop's: median {np.median(forces[..., k]):.0f} "
            f"({forces[..., k].min():.0f}, {forces[..., k].max():.0f}), "
            f"{100 * (forces[..., k] <= 102).mean():.0f} % of feet at most 102"
        )
    yield f"  step: median {np.median([one.step_us for one in rows]):.0f} us"


def reality_lines(rows: Sequence[Judged]) -> Iterator[str]:
    """Sum up each walk in a row of a Markdown table, those of a reality together."""
    yield (
        "reality, gait | given | ok | NEES of velocity, pose | bad stretches, doubted; "
        "good ones doubted | vx, vy, yaw rate RMSE over the open loop's"
    )
    yield "---|---|---|---|---|---"
    for one in sorted(rows, key=lambda row: (row.world.reality, row.world.gait)):
        bad, doubted = one.bad, one.doubted
        yield (
            f"{one.world.reality}, {one.world.gait} | {one.mode.name} | {100 * one.ok:.0f} % | "
            f"{one.nees[0]:.1f}, {one.nees[1]:.1f} | {bad.sum()} of {len(bad)}, "
            f"{(bad & doubted).sum()}; {(~bad & doubted).sum()} | "
            + ", ".join(f"{share:.0f}" for share in one.of_naive) + " %"
        )  # fmt: skip


def noticed(fault: str, gait: str) -> str:
    """Walk with one large fault and say what the estimator says of it."""
    config = load_robot()
    twin = apply_effects(nominal_twin(config, 1), (parse_effect(fault, EFFECTS),), EFFECTS)
    with TemporaryDirectory() as name:
        path = Path(name) / "walk.mcap"
        walk_without_bytes(config, gait, 2.0, 1, path, twin, imu_of(1))
        tracker = Tracker(config, no_imu=True)
        for item in read_stamped_ticks(path):
            tracker.take(item.unix_ns, item.tick.sensed)
        span = walking_part(read_log(path))
    said = tracker.track().part(span).estimates
    ok = np.mean([one.health is Health.OK for one in said])
    last = next((one for one in reversed(said) if one.remark or one.reason), said[-1])
    words = "; ".join(text for text in (last.reason, last.remark) if text) or "nothing"
    return f"{fault} ({gait}): ok in {100 * ok:.0f} % of the ticks; {words}"


def main() -> None:
    """Judge, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("seeds", type=int, nargs="*")
    parser.add_argument(
        "--realities", action="store_true", help="robots that are built differently"
    )
    parser.add_argument("--faults", action="store_true", help="one large fault a walk")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with Pool(options.jobs) as pool:
        if options.faults:
            cases = [(fault, gait) for fault in FAULTS for gait in GAITS]
            for line in pool.starmap(noticed, cases):
                print(line, flush=True)
            return
        if options.folder is None:
            parser.error("name the folder that benchmarks.odometry.worlds made")
        worlds = worlds_of(options.seeds, realities=options.realities, default=JUDGED_SEEDS)
        walks = pool.starmap(judge, [(options.folder, world) for world in worlds], chunksize=1)
        rows = [one for walk in walks for one in walk]
    if options.realities:
        print(*reality_lines(rows), sep="\n")
        return
    for gait in GAITS:
        for mode in MODES:
            part = [one for one in rows if one.world.gait == gait and one.mode == mode]
            if part:
                print(
                    f"{gait}, {mode.name}, {len(part)} walks", *lines_of(part), sep="\n", flush=True
                )


if __name__ == "__main__":
    main()
