"""Earlier files that new ones would replace: kept under another name, unless they may be overwritten."""

import filecmp
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from model.errors import RecordError


@dataclass(frozen=True, slots=True)
class _Policy:
    """What becomes of earlier files, and who is notified of one that was renamed."""

    overwrite: bool
    notify: Callable[[str], None]


_KEPT = _Policy(overwrite=False, notify=lambda _: None)
_policy = ContextVar("_policy", default=_KEPT)


@contextmanager
def earlier_files(*, overwrite: bool, notify: Callable[[str], None]) -> Iterator[None]:
    """Choose what becomes of earlier files in the block; without a choice they are kept.

    Args:
        overwrite: Whether new files replace them.
        notify: Called with a line about each file that was kept.
    """
    token = _policy.set(_Policy(overwrite, notify))
    try:
        yield
    finally:
        _policy.reset(token)


def keep_earlier(path: Path) -> Path | None:
    """Rename a file that a new one would replace, to ``NAME.1.mcap`` for example, and notify.

    Args:
        path: Where a new file is to be written.

    Returns:
        Its new name; None where there was nothing to keep, or it may be overwritten.

    Raises:
        RecordError: It cannot be renamed.
    """
    policy = _policy.get()
    if policy.overwrite or not path.is_file() or path.stat().st_size == 0:
        return None
    number = 1
    while (other := path.with_name(f"{path.stem}.{number}{path.suffix}")).exists():
        number += 1
    try:
        path.rename(other)
    except OSError as error:
        raise RecordError(
            f"{path} is there and cannot be kept as {other.name}: {error.strerror}; choose another name"
        ) from error
    policy.notify(f"note: the earlier {path} is now {other}")
    return other


def same_content(new: Path, path: Path) -> bool:
    """Whether a new file holds what is in the earlier one already, byte for byte."""
    return path.is_file() and filecmp.cmp(new, path, shallow=False)
