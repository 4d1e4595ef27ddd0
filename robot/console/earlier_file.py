"""A measurement is not lost to the next one of the same name."""

from pathlib import Path

from model.errors import RecordError
from robot.console.program_output import complain


def keep_earlier(path: Path) -> Path | None:
    """Give a file that is there already another name, ``NAME.1.mcap`` say, and tell.

    Args:
        path: Where a new file is to be written.

    Returns:
        Its new name; None where there was nothing to keep.

    Raises:
        RecordError: It cannot be renamed.
    """
    if not path.is_file() or path.stat().st_size == 0:
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
    complain(f"note: the earlier {path} is now {other}")
    return other
