"""Logs in a notebook: columns of ``record.log.recording`` as attributes, and the file behind them."""

import shutil
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import TYPE_CHECKING, Any

import numpy as np

from model.errors import ConfigError
from model.values.arrays import BoolArray
from model.values.tick import Mode
from record.log.blocks.read import read_log as read_recording
from record.log.columns import check_groups
from record.log.export import export_table
from record.log.reader import LogContents
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.installed import how_to_install
from robot.gap_report.imports import imported, lines_of_one
from robot.requests.recorded import ImportRequest

if TYPE_CHECKING:
    import pyarrow

USUAL_GROUPS = ("joints", "forces", "truth")


@dataclass(frozen=True, eq=False, repr=False)
class Log(Recording):
    """A log of T ticks and N legs: arrays, and the file for all that reads whole ticks.

    The arrays are those of ``Recording``; ``help(bigant.Log)`` lists them with shapes and units.

    Attributes:
        path: The log file. That of a walk which was not saved is removed together with this value.
        notes: What an import found in the table, a line each.
    """

    path: Path
    notes: tuple[str, ...] = ()

    @property
    def robot(self) -> RobotConfig:
        """The robot file in the log, read.

        Raises:
            ConfigError: There is none, or it cannot be used.
        """
        return parse_robot(self.config_text)

    @property
    def walking(self) -> BoolArray:
        """Whether the robot walked, (T,)."""
        walks: BoolArray = self.mode == Mode.WALK.value
        return walks

    def save(self, path: str | Path) -> "Log":
        """Copy the log file, and return the log with its new path.

        Raises:
            FileExistsError: There is a file already.
        """
        out = Path(path)
        if out.exists():
            raise FileExistsError(f"{out} is there already; remove it, or choose another name")
        shutil.copyfile(self.path, out)
        return _log(self, out, self.notes)

    def table(self, *groups: str) -> "pyarrow.Table":
        """Return ticks as a table, a row a tick: ``log.table("joints", "forces").to_pandas()``.

        Args:
            groups: Of ``bigant log export``: joints, commands, forces, model, dead_reckoning, estimate,
                truth, loop, raw. None of them: joints, forces and truth.

        Raises:
            ConfigError: There is no such group, or pyarrow, whose table it is, is not installed.
            RecordError: The file cannot be read.
        """
        try:
            from pyarrow import parquet
        except ImportError as error:
            raise ConfigError(
                "table", f"needs pyarrow; install it with: {how_to_install('arrow')}"
            ) from error
        chosen = check_groups(",".join(groups)) if groups else USUAL_GROUPS
        with TemporaryDirectory() as folder:
            out = Path(folder) / "ticks.parquet"
            export_table(self.path, out, chosen, LogContents())
            return parquet.read_table(out)

    def rows(self) -> list[tuple[str, str]]:
        """Return what a notebook shows: label and words."""
        seconds = float(self.t_s[-1] - self.t_s[0])
        walked = float(self.walking.mean()) * seconds
        kinds = ", ".join(sorted({fault.kind.name for _, fault in self.faults})) or "none"
        gait = self.metadata.get("gait", "")
        rows = [
            ("robot", f"{self.metadata.get('robot', 'unknown')}, legs {', '.join(self.names)}"),
            ("run", f"{gait or 'no gait'} on {self.metadata.get('hardware', 'unknown hardware')}"),
            ("ticks", f"{len(self.t_s)} in {seconds:.2f} s, {walked:.2f} s of it walking"),
            ("ground truth", "yes" if self.has_truth else "no"),
            ("foot forces", "yes" if np.isfinite(self.force_n).any() else "no"),
            ("faults", kinds),
        ]
        return [*rows, ("damage", self.damage)] if self.damage else rows

    def __repr__(self) -> str:
        """Return a few lines about the run."""
        rows = [f"  {label:<13} {words}" for label, words in self.rows()]
        return "\n".join([f"Log {self.path.name}", *rows, *(f"  {note}" for note in self.notes)])


def read_log(path: str | Path, notes: tuple[str, ...] = ()) -> Log:
    """Read a log (.mcap), whole; an hour takes a gigabyte.

    Args:
        path: The log.
        notes: What is to stand in the log's ``notes``.

    Raises:
        RecordError: It cannot be opened, or holds no tick that can be read.
    """
    return _log(read_recording(Path(path)), Path(path), notes)


def import_table(
    table: str | Path,
    columns: str | Path | None = None,
    out: str | Path | None = None,
    topics: Mapping[str, str] | None = None,
) -> Log:
    """Bring measured data in as a log, as ``bigant import`` does; its ``notes`` say what is odd there.

    Where the map names a robot file, the log holds the estimator's answer too, as after the command. Other
    files of the same run, with clocks of their own, are named in the map: ``[file.NAME]``, docs/log.md.

    Args:
        table: .csv, .parquet, .npz or NAME.toml; or a ROS 2 bag, its folder, its .mcap or its .db3.
        columns: Map of its columns or topics and of the run's other files (MAP.toml), or the name of one
            that comes with the program; None if a table has our names, or a bag's topics say what they are.
        out: Log (.mcap) to write; a temporary one if None.
        topics: Of a bag, where several could be meant: ``{"joints": "/joint_states", "pose": "/mocap"}``,
            also ``commands`` and ``force_LEG``.

    Raises:
        ConfigError: ``out`` is no log, the map is none, or ``topics`` names nothing.
        RecordError: The data cannot be read, nothing in them is known, or a clock cannot be aligned.
    """
    if out is not None and Path(out).suffix != ".mcap":
        raise ConfigError("out", f"must end in .mcap, not {out}")

    def write(path: Path) -> list[str]:
        request = ImportRequest(
            paths=(Path(table),),
            map=None if columns is None else str(columns),
            topics=",".join(f"{what}={topic}" for what, topic in (topics or {}).items()) or None,
            out=path,
        )
        (report,) = imported(request)
        return lines_of_one(report)

    if out is None:
        return new_log(f"{Path(table).stem}.mcap", write)
    notes = write(Path(out))
    return read_log(out, tuple(notes))


def path_of(log: Log | str | Path) -> Path:
    """Return the file of a log, or of what names one."""
    return log.path if isinstance(log, Log) else Path(log)


def new_log(name: str, write: Callable[[Path], Sequence[str] | None]) -> Log:
    """Write a log into a folder of its own, removed when nobody holds the log any more, and read it.

    Args:
        name: Of the file.
        write: Writes it, and returns notes about it, if there are any.
    """
    folder = Path(mkdtemp(prefix="bigant-"))
    try:
        notes = write(folder / name)
        log = read_log(folder / name, tuple(notes or ()))
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(log, shutil.rmtree, folder, ignore_errors=True)
    return log


def _log(recording: Recording, path: Path, notes: tuple[str, ...] = ()) -> Log:
    columns: dict[str, Any] = {one.name: getattr(recording, one.name) for one in fields(Recording)}
    return Log(**columns, path=path, notes=notes)
