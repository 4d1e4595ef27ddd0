"""Machine code of kernels kept on disk, once for each user and version of the sources.

numba keeps it beside each copy of a module, and two processes that compile the same function for
different types at once can mix up its index. Here every kernel and every set of types has a file of its
own in one folder of the user's cache, named after the sources that it depends on: a second clone or
environment with the same sources compiles nothing. It is the only part of ``model`` that touches files,
and it computes nothing.
"""

import hashlib
import os
import sys
import tempfile
from contextlib import suppress
from pickle import loads
from typing import Any

from platformdirs import user_cache_dir

# A kernel that no process has loaded for so long is removed.
KEPT_S = 60 * 86400.0
DIGEST_BYTES = 32


def kernel_folder() -> str:
    """Return where machine code is kept: ``NUMBA_CACHE_DIR`` if it is set, else in the user's cache."""
    return os.environ.get("NUMBA_CACHE_DIR") or os.path.join(
        user_cache_dir("bigant", appauthor=False), "kernels"
    )


class KernelFiles:
    """Takes the place of numba's index and data files of one function.

    What cannot be read, is damaged or belongs to other types is compiled again; what cannot be written is
    compiled again by the next process (``bigant doctor`` reports it).

    Args:
        function: Module and name of the function.
        stamp: Digest of all sources that its machine code depends on.
        version: Version of the compiler.
        folder: Where the files are.
    """

    def __init__(self, function: str, stamp: str, version: str, folder: str) -> None:
        self._function, self._folder = function, folder
        self._made_from = f"{stamp} {version} {sys.implementation.cache_tag}"

    def path(self, key: Any) -> str:
        """Return the file of a set of types and a processor."""
        digest = hashlib.sha256(f"{self._made_from} {key!r}".encode()).hexdigest()
        return os.path.join(self._folder, f"{self._function}-{digest[:32]}.kernel")

    def load(self, key: Any) -> Any:
        """Return the machine code kept for a key, None if there is none."""
        path = self.path(key)
        try:
            with open(path, "rb") as file:
                digest, content = file.read(DIGEST_BYTES), file.read()
        except OSError:
            return None
        if hashlib.sha256(content).digest() != digest:  # cut off by a full disk
            return None
        kept_key, data = loads(content)
        if kept_key != key:
            return None
        with suppress(OSError):
            os.utime(path)  # still in use
        return data

    def save(self, key: Any, data: Any) -> None:
        """Keep machine code; a reader finds all of it or nothing."""
        from numba.core import serialize

        dumps: Any = serialize.dumps  # has no types
        content: bytes = dumps((key, data))
        with suppress(OSError):
            os.makedirs(self._folder, exist_ok=True)
            number, name = tempfile.mkstemp(dir=self._folder, prefix="unfinished-")
            try:
                with os.fdopen(number, "wb") as file:
                    file.write(hashlib.sha256(content).digest() + content)
                os.replace(name, self.path(key))
                _remove_unused(self._folder, now_s=os.stat(self.path(key)).st_mtime)
            except OSError:
                os.unlink(name)
                raise

    def flush(self) -> None:
        """Forget nothing: other processes may use the same files."""


_tidied: set[str] = set()


def _remove_unused(folder: str, now_s: float) -> None:
    """Once in a process, remove kernels of versions that nobody starts any more."""
    if folder in _tidied:
        return
    _tidied.add(folder)
    for entry in os.scandir(folder):
        if entry.name.endswith(".kernel") or entry.name.startswith("unfinished-"):
            with suppress(OSError):  # another process was faster
                if entry.stat().st_mtime < now_s - KEPT_S:
                    os.unlink(entry.path)
