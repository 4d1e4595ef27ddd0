"""Workers share what the first run on a fresh clone costs: asserts of each test file are rewritten once.

All workers collect all tests. In the same order, each of them would come to every file before another has
written its rewritten copy, and rewriting takes longer than importing. So each worker imports its own part
of the files first, and finds the copies of the others' parts.
"""

import contextlib
import importlib
from pathlib import Path

import pytest


def import_own_part_first(config: pytest.Config) -> None:
    """Import all test files of the folders that were asked for, in another order in each worker."""
    worker: dict[str, object] = getattr(config, "workerinput", {})
    if not worker:
        return
    files = [
        path
        for asked in config.args
        if Path(asked).is_dir()
        for path in sorted(Path(asked).resolve().rglob("test_*.py"))
    ]
    number, workers = int(str(worker["workerid"])[2:]), int(str(worker["workercount"]))
    first = len(files) * number // workers
    for path in (*files[first:], *files[:first]):
        # whatever is wrong with a file is told when it is collected
        with contextlib.suppress(Exception, pytest.skip.Exception):
            name = path.relative_to(config.rootpath).with_suffix("").parts
            importlib.import_module(".".join(name))
