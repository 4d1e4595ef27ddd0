"""What one picture of a film shows: robot, legs, forces and slip; from a log or a trial."""

import math
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.motion.differentiate import centred_rate
from model.motion.se2 import quaternion_of
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import RobotParameters
from model.values.tick import Tick
from record.log.export import export_trial
from record.log.reader import LogContents, StampedTick
from record.trial.trial import Trial, read_trial
from robot.config.robot_file import parse_robot
from robot.report.scene import (
    COUPLER,
    LOADED,
    MEASURED,
    METRES_PER_NEWTON,
    Arrow,
    Body,
    Dot,
    LegScene,
    Strip,
    body_of,
    legs_of,
)

TRUE, ESTIMATED, RECKONED, MEASURED_POSE = (
    "ground truth", "estimator", "dead reckoning", "motion capture"
)  # fmt: skip
# Of a trial: a foot that carries more than this is loaded, and slips as its marker moves.
LOADED_N = 1.0
HALF_WINDOW_NS = 50_000_000
EVERY_S = 0.02  # of a log: enough for paths, slip and 50 pictures a second
# Beyond these it is no run of a robot, and a picture would show nothing of it.
FARTHEST_M, LARGEST_RAD, LARGEST_N = 1e4, 1e6, 1e6


@dataclass(frozen=True, slots=True, eq=False)
class FilmFrame:
    """One moment.

    Attributes:
        time_s: Since the film's run began.
        position: Body origin in the world, (3,) [m].
        turn: Body to world.
        pose_from: Where the pose comes from, in words.
        body: The body as a box.
        legs: Legs with their forces, in the body frame.
        loaded: Which feet are on the ground, (N,).
        slip_m_s: Speed of each loaded foot over the ground, (N,) [m/s]; NaN in the air and where unknown.
        words: What the robot does: mode, gait, speed.
    """

    time_s: float
    position: FloatArray
    turn: Rotation
    pose_from: str
    body: Body
    legs: tuple[LegScene, ...]
    loaded: BoolArray
    slip_m_s: FloatArray
    words: str


def tick_frames(ticks: Iterable[StampedTick], parameters: RobotParameters) -> Iterator[FilmFrame]:
    """Yield a frame for every fiftieth of a second of a log in which the robot's place is known.

    Args:
        ticks: In order.
        parameters: Dimensions, from the log's own robot file.

    Raises:
        RecordError: Nobody's robot can be where a tick says it is.
    """
    first_ns: int | None = None
    source, body, next_s = "", body_of(parameters), 0.0
    for stamped in ticks:
        first_ns = stamped.unix_ns if first_ns is None else first_ns
        time_s, tick = (stamped.unix_ns - first_ns) * 1e-9, stamped.tick
        if time_s < next_s:
            continue
        next_s = time_s + EVERY_S - 1e-4
        places = _places(tick)
        source = source or next(iter(places), "")
        if source not in places:
            continue  # the frames of two sources differ: one film has one
        position, turn = places[source]
        if absurd := absurd_words(position[None], np.zeros((1, 3)), tick.forces.force_n[None]):
            raise RecordError(f"at {time_s:.2f} s {absurd[1]}; leave that part of it out")
        loaded, slip = _slip(tick)
        legs = legs_of(tick, parameters)
        yield FilmFrame(time_s, position, turn, source, body, legs, loaded, slip, _words(tick))


def _places(tick: Tick) -> dict[str, tuple[FloatArray, Rotation]]:
    """Where the body is, by source, the best first: ground truth, the estimator, the model alone."""
    truth, height = tick.inputs.truth, tick.contact.support.height_m
    places = {}
    if truth is not None and np.isfinite([*truth.position_W, *truth.quaternion_xyzw]).all():
        places[TRUE] = truth.position_W, Rotation.from_quat(truth.quaternion_xyzw)
    planar = [] if tick.estimate is None else [(ESTIMATED, tick.estimate.pose)]
    for source, pose in (*planar, (RECKONED, tick.dead_reckoning.pose)):
        if np.isfinite([*pose, height]).all():
            turn = Rotation.from_quat(quaternion_of(float(pose[2])))
            places[source] = np.array([*pose[:2], height]), turn
    return places


def _slip(tick: Tick) -> tuple[BoolArray, FloatArray]:
    """Which feet are loaded, and how fast they slip: true if that is known, else as the model has it."""
    truth = tick.inputs.truth
    if truth is not None and np.isfinite(truth.foot_velocity_W).any():
        loaded = np.asarray(truth.contact, dtype=bool)
        speed = np.linalg.norm(truth.foot_velocity_W[:, :2], axis=1)
    else:
        loaded = np.asarray(tick.contact.support.contact, dtype=bool)
        speed = np.linalg.norm(tick.contact.traction.slip_B, axis=1)
    return loaded, np.where(loaded, speed, np.nan)


def _words(tick: Tick) -> str:
    predicted = tick.contact.traction.velocity_B[0] * 1e3
    truth = tick.inputs.truth
    speeds = [f"model {round(float(predicted))}"] if math.isfinite(predicted) else []
    if truth is not None and math.isfinite(float(truth.velocity_B[0])):
        speeds.insert(0, f"true {round(float(truth.velocity_B[0]) * 1e3)}")
    speed = f"   forward mm/s: {', '.join(speeds)}" if speeds else ""
    return f"{tick.mode.name.lower()}{speed}"


def read_table(path: Path) -> Trial:
    """Read a trial, or the walk of a log as one.

    Raises:
        RecordError: It cannot be read.
    """
    if path.suffix != ".mcap":
        return read_trial(path)
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "run.parquet"
        export_trial(path, table, LogContents())
        return read_trial(table)


def trial_frames(trial: Trial, name: str) -> list[FilmFrame]:
    """Return a frame for each sample of a trial with poses of body and feet.

    Args:
        trial: Its feet are drawn where their markers were.
        name: What it is called in a complaint.

    Raises:
        RecordError: It holds no such poses, or some that are no robot's.
    """
    if absurd := absurd_words(
        trial.body_position_m, trial.body_angles_rad, trial.force_n, trial.foot_m
    ):
        row, words = absurd
        raise RecordError(
            f"{name} cannot be drawn: at {trial.time_s[row]:.2f} s {words}; leave that part of it out"
        )
    known = np.isfinite(trial.body_position_m).all(axis=1)
    known &= np.isfinite(trial.body_angles_rad).all(axis=1)
    known &= np.isfinite(trial.foot_m).any(axis=(1, 2))
    if not known.any():
        raise RecordError(f"{name} holds no poses of body and feet to draw")
    time_s, position, feet = trial.time_s[known], trial.body_position_m[known], trial.foot_m[known]
    roll, pitch, yaw = trial.body_angles_rad[known].T
    turns = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=1))
    world = position[:, None] + np.einsum("tij,tnj->tni", turns.as_matrix(), feet)
    moved = world[..., :2].reshape(len(world), -1)
    rate = centred_rate(np.round(time_s * 1e9).astype(np.int64), moved, HALF_WINDOW_NS)
    speed = np.linalg.norm(rate.reshape(len(world), -1, 2), axis=2)
    force = trial.force_n[known]
    loaded = np.nan_to_num(force[..., 2]) > LOADED_N
    slip = np.where(loaded, speed, np.nan)
    hips = _hips(trial, feet)
    body = _box(hips)
    names = trial.header.joints
    return [
        FilmFrame(
            float(time_s[row]),
            position[row],
            turns[row],
            MEASURED_POSE,
            body,
            tuple(
                _marked_leg(names[leg], hips[leg], feet[row, leg], force[row, leg])
                for leg in range(len(hips))
            ),
            loaded[row],
            slip[row],
            trial.header.gait,
        )
        for row in range(len(time_s))
    ]


def _marked_leg(name: str, hip: FloatArray, foot: FloatArray, force_n: FloatArray) -> LegScene:
    """A leg of which only hip and marker are known."""
    if not np.isfinite(foot).all():
        return LegScene(name, (), (), ())
    loaded = bool(np.nan_to_num(force_n[2]) > LOADED_N)
    arrows = (Arrow(foot, METRES_PER_NEWTON * force_n, MEASURED),) if loaded else ()
    return LegScene(name, (Strip(np.stack([hip, foot]), COUPLER),), (Dot(foot, LOADED),), arrows)


def _hips(trial: Trial, feet: FloatArray) -> FloatArray:
    """Return the shafts in the body frame, or where there is no robot file, the feet's middles raised."""
    if trial.header.robot_text:
        shafts: FloatArray = parse_robot(trial.header.robot_text).parameters.legs.shaft_position
        return shafts
    middle: FloatArray = np.nanmean(feet, axis=0)
    middle[:, 2] = 0.0
    return middle


def _box(hips: FloatArray) -> Body:
    low, high = np.nanmin(hips, axis=0), np.nanmax(hips, axis=0)
    return Body((low + high) / 2, (high - low) * [1.0, 0.7, 1.0] + [0.06, 0.06, 0.04])


def absurd_words(
    position: FloatArray, angles: FloatArray, force: FloatArray, feet: FloatArray | None = None
) -> tuple[int, str] | None:
    """Return the row and words of the first thing that is no robot's; None if there is none."""
    for what, values, most, unit in (
        ("the body is", position, FARTHEST_M, "m away"),
        ("the body is turned by", angles, LARGEST_RAD, "rad"),
        ("a foot is", position[:0] if feet is None else feet, FARTHEST_M, "m from the body"),
        ("a foot carries", force, LARGEST_N, "N"),
    ):
        rows = np.abs(values.reshape(len(values), math.prod(values.shape[1:])))
        largest = np.where(np.isnan(rows), 0.0, rows).max(axis=1, initial=0.0)
        if (largest > most).any():
            at = int(np.argmax(largest > most))
            return at, f"{what} {largest[at]:.3g} {unit}"
    return None
