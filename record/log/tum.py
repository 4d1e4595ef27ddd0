"""Trajectories as TUM files, which evo reads: lines of ``unix_s x y z qx qy qz qw`` in s and m."""

from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from model.motion.se2 import quaternion_of
from model.values.arrays import FloatArray
from record.whole_file import clear_name, whole_file, writing


class TumFile:
    """A trajectory, written pose by pose.

    Poses that are not known are left out, and so are those that are not later than the one before. A
    file that got none is not kept.

    Args:
        path: The file.
        growing: Whether lines stand in ``path`` at once; else the file is there only when it is whole.

    Raises:
        RecordError: It cannot be written.
    """

    def __init__(self, path: Path, *, growing: bool = False) -> None:
        self.path = path
        self.count = 0
        self._last_ns = -1
        self._whole = ExitStack()
        if growing:
            clear_name(path)
        self._place = path if growing else self._whole.enter_context(whole_file(path))
        with writing(path):
            self._file = self._place.open("w", encoding="ascii")

    def write(self, unix_ns: int, pose: FloatArray) -> None:
        """Write a pose: x, y [m], yaw [rad], (3,), or place and quaternion x y z w, (7,).

        Raises:
            RecordError: It cannot be written.
        """
        if not np.isfinite(pose).all() or unix_ns <= self._last_ns:
            return
        if len(pose) == 3:
            pose = np.array([*pose[:2], 0.0, *quaternion_of(pose[2])])
        seconds, rest = divmod(unix_ns, 10**9)  # a float of seconds holds no nanoseconds
        line = f"{seconds}.{rest:09d} " + " ".join(f"{value:.9f}" for value in pose)
        with writing(self.path):
            self._file.write(f"{line}\n")
        self.count, self._last_ns = self.count + 1, unix_ns

    def flush(self) -> None:
        """Let readers of a growing file see what has been written."""
        self._file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with writing(self.path):
            self._file.close()
            if not self.count and self._place.is_file():
                self._place.unlink()
        self._whole.__exit__(kind, error, trace)
