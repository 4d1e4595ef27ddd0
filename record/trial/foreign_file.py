"""Files of other people's programs, read by other people's libraries: damage in them is one error.

Such a library reads every file that is sound. What it raises on one that is not depends on where the damage
lies: errors of its own, of zip, YAML or SQLite, of memory, of a text that is none, of Python's stack.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from model.errors import BigantError, RecordError


@contextmanager
def foreign_file(words: str) -> Iterator[None]:
    """Turn whatever a library raises while it reads a file into one error.

    Args:
        words: What cannot be read, as in "the table a.csv cannot be read".

    Raises:
        RecordError: The block raised something; errors of ours stay as they are.
    """
    try:
        yield
    except BigantError:
        raise
    except UnicodeDecodeError as error:
        raise RecordError(f"{words}: it is not UTF-8 text") from error
    except Exception as error:
        reason = str(error).splitlines()[0] if str(error).strip() else type(error).__name__
        raise RecordError(f"{words}: {reason}") from error
