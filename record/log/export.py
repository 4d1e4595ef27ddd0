"""A log as files that other programs read: tables, trials and trajectories, in bounded memory."""

from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.motion.attitude import roll_pitch_yaw
from model.motion.se2 import yaw_of
from model.values.arrays import FloatArray
from model.values.machine_names import MachineNames, one_joint_a_leg
from record.log.columns import GROUPS, TRIAL_PARTS, named, table_columns
from record.log.reader import LogContents, StampedTick, tick_blocks
from record.log.recording import LEGS, Stack, follow
from record.log.tum import TumFile
from record.trial.header import TrialHeader, joints_of, kind_of, legs_of
from record.trial.header_file import parse_header, parse_toml, write_header
from record.trial.table_file import TableColumn, check_suffix
from record.trial.table_writer import copy_table, table_writer
from record.trial.trial import BODY_ANGLES
from record.trial.trial import COLUMNS as TRIAL_COLUMNS

BLOCK_TICKS = 1000
# Trajectories of a TUM export: where their poses are in a tick.
POSES = {
    "estimate": "estimate.pose",
    "dead_reckoning": "dead_reckoning.pose",
    "truth": "inputs.truth.pose",
}


@dataclass(frozen=True, slots=True)
class Exported:
    """What an export wrote.

    Attributes:
        path: A file.
        rows: Its rows or poses.
    """

    path: Path
    rows: int


def _names(block: Sequence[StampedTick], contents: LogContents) -> MachineNames:
    return contents.machine(block[0].tick)


def export_table(
    path: Path, out: Path, groups: tuple[str, ...], contents: LogContents
) -> tuple[Exported, ...]:
    """Write a table of what every tick holds.

    Args:
        path: The log.
        out: A .parquet or .csv file.
        groups: Which columns, see ``record.log.columns.GROUPS``.
        contents: Filled on the way.

    Raises:
        RecordError: The log cannot be read, or the table cannot be written.
    """
    start_ns: int | None = None
    parts = [part for group in groups for part in GROUPS[group]]
    with table_writer(out) as writer:
        for block in tick_blocks(path, contents, BLOCK_TICKS):
            start_ns = contents.start_unix_ns(block[0].unix_ns) if start_ns is None else start_ns
            writer.write(table_columns(block, _names(block, contents), start_ns, parts))
    return (Exported(out, writer.rows),)


def export_trial(path: Path, out: Path, contents: LogContents) -> tuple[Exported, ...]:
    """Write a log as a trial: NAME.parquet or NAME.csv, NAME.toml and the robot file.

    Columns in which nothing was measured are left out. Body and feet are the ground truth's, if there is
    any; the model's and the estimator's outputs are no measurements and do not go in.

    Raises:
        RecordError: The log cannot be read, or a file cannot be written.
    """
    check_suffix(out)
    whole = out.with_name(out.stem + ".whole.parquet")
    measured: dict[str, bool] = {}
    names = one_joint_a_leg(())
    last_yaw, start_ns, times_s = np.nan, -1, []
    try:
        with table_writer(whole) as writer:
            for block in tick_blocks(path, contents, BLOCK_TICKS):
                if start_ns < 0:
                    names = _names(block, contents)
                    start_ns = contents.start_unix_ns(block[0].unix_ns)
                columns, last_yaw = _trial_columns(block, names, start_ns, last_yaw)
                for column in columns:
                    known = bool(np.isfinite(column.values).any())
                    measured[column.name] = measured.get(column.name, False) or known
                times_s.append(columns[0].values)
                writer.write(columns)
        steps_s = np.diff(np.concatenate(times_s))
        rate_hz = 1 / float(np.median(steps_s)) if len(steps_s) else np.nan
        write_header(_trial_header(path, names, contents, rate_hz), out.with_suffix(".toml"))
        copy_table(whole, out, [name for name, known in measured.items() if known])
    finally:
        with suppress(OSError):
            whole.unlink()
    return (Exported(out, writer.rows), Exported(out.with_suffix(".toml"), 0))


def _trial_header(
    path: Path, names: MachineNames, contents: LogContents, rate_hz: float
) -> TrialHeader:
    metadata, source = contents.metadata, f"the header in {path}"
    if "trial" in metadata and "merged" not in metadata:  # it was one before it became a log
        text = parse_toml(metadata["trial"], Path(source))
        return parse_header(text, Path(source), (), contents.config_text)
    robot_file = (
        f"{(metadata.get('robot') or 'robot').lower()}.toml" if contents.config_text else ""
    )
    robot = parse_toml(contents.config_text, path)
    joints = joints_of(robot, ())
    if joints and joints != names.joints:
        raise RecordError(f"{path}: its robot file has joints {joints}, its ticks {names.joints}")
    return TrialHeader(
        kind=kind_of(robot, path),
        joints=names.joints,
        gait=metadata.get("gait", ""),
        frequency_hz=_float(metadata.get("frequency_hz", "")),
        sample_rate_hz=round(rate_hz, 6),
        notes=f"from {path.name}" + (f"; {contents.damage}" if contents.damage else ""),
        robot_file=robot_file,
        robot_text=contents.config_text,
        legs=legs_of(robot),
    )


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def _trial_columns(
    block: Sequence[StampedTick], names: MachineNames, start_ns: int, last_yaw: float
) -> tuple[list[TableColumn], float]:
    """Return every column of a trial, also those without a number, and the last yaw."""
    ticks = [item.tick for item in block]
    time_s, _, *columns = table_columns(block, names, start_ns, TRIAL_PARTS)
    position = Stack("inputs.truth.position_W", (3,)).of(ticks)
    quaternion = Stack("inputs.truth.quaternion_xyzw", (4,)).of(ticks)
    angles, last_yaw = _roll_pitch_yaw(quaternion, last_yaw)
    feet = Stack("inputs.truth.foot_position_W", (LEGS, 3)).of(ticks, len(names.legs))
    columns += named(BODY_ANGLES, angles, names)
    columns += named(
        TRIAL_COLUMNS["foot_m"], _in_body(feet - position[:, None, :], quaternion), names
    )
    return [time_s, *columns], last_yaw


def _roll_pitch_yaw(quaternion: FloatArray, last_yaw: float) -> tuple[FloatArray, float]:
    """Return (T, 3) angles, the yaw unwrapped from the block before on, and its last value."""
    angles = np.full((len(quaternion), 3), np.nan)
    known = np.isfinite(quaternion).all(axis=1)
    yaw = yaw_of(quaternion)
    if known.any():
        turns = roll_pitch_yaw(Rotation.from_quat(quaternion[known]))
        angles[known, :2], yaw[known] = turns[:, :2], turns[:, 2]
    known = np.isfinite(yaw)
    if known.any():
        before = yaw[known][0] if np.isnan(last_yaw) else last_yaw
        angles[known, 2] = np.unwrap(np.concatenate([[before], yaw[known]]))[1:]
        last_yaw = float(angles[known][-1, 2])
    return angles, last_yaw


def _in_body(arms: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Turn vectors of the world, (T, N, 3), into the body frame: what markers on the feet would give."""
    known = np.isfinite(quaternion).all(axis=1)
    feet = np.full(arms.shape, np.nan)
    if known.any():
        to_world = Rotation.from_quat(quaternion[known]).as_matrix()
        feet[known] = np.einsum("tji,tnj->tni", to_world, arms[known])
    return feet


def export_tum(path: Path, out: Path, contents: LogContents) -> tuple[Exported, ...]:
    """Write trajectories in the TUM format that evo reads: estimate, dead reckoning and truth.

    The first two are planar and in their own frame: compare with alignment. A file without a known pose
    is not written.

    Args:
        path: The log.
        out: Stem of the files: OUT_estimate.tum, OUT_dead_reckoning.tum and OUT_truth.tum.
        contents: Filled on the way.

    Raises:
        RecordError: The log cannot be read, or a file cannot be written.
    """
    base = out.with_suffix("") if out.suffix == ".tum" else out
    with ExitStack() as stack:
        files = [
            stack.enter_context(TumFile(base.with_name(f"{base.name}_{kind}.tum")))
            for kind in POSES
        ]
        for block in tick_blocks(path, contents, BLOCK_TICKS):
            for item in block:
                for file, where in zip(files, POSES.values(), strict=True):
                    if (pose := follow(item.tick, where)) is not None:
                        file.write(item.unix_ns, pose)
    return tuple(Exported(file.path, file.count) for file in files if file.count)
