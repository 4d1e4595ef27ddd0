"""A file that is there only when it is whole: written beside its place, and moved there at the end."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(out: Path) -> Iterator[Path]:
    """Yield the name to write to; it becomes ``out`` at the end, and is removed if the block fails.

    Args:
        out: Where the file is to be. What is there stays until then.
    """
    part = out.with_name(f".{out.stem}.part{out.suffix}")  # the suffix tells writers the kind
    try:
        yield part
        part.replace(out)
    finally:
        part.unlink(missing_ok=True)
