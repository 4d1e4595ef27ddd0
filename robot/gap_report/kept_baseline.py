"""Baseline model errors of references, kept in the user's cache: the same healthy runs are searched once.

They depend on the references, on what feeds the stages, and on the program; a file is named after all of
them, so that none outlives a change of either.
"""

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path

from platformdirs import user_cache_path

from gap.diagnosis.comparison.commissioning import commission
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause
from model.errors import RecordError
from record.earlier_file import earlier_files
from record.trial.header import LEGGED
from robot.gap_report.causes_file import read_causes, write_causes
from robot.gap_report.trial_bytes import arrays_of, bytes_of

FOLDER = "baselines"
# What a baseline is computed from besides the runs.
PACKAGES = ("gap", "model", "record")
REUSED = (
    "baseline model errors: reused from an earlier diagnosis with these references "
    "(--fresh finds them again)"
)


def baseline_of(study: Study, kind: str, *, fresh: bool) -> tuple[tuple[Cause, ...] | None, bool]:
    """Return what the references of a study show already, and whether it was kept from before.

    Args:
        study: Trials and references.
        kind: Kind of their machine, empty for one whose file is not part of the runs: then nothing is kept.
        fresh: Search again, and keep the new answer.

    Returns:
        None where there are too few references, or where nothing may be kept: the diagnosis then decides.
    """
    if kind != LEGGED or not study.calibrated:
        return None, False
    path = _folder() / f"{_digest(study)}.json"
    if not fresh:
        kept = _read(path)
        if kept is not None:
            return kept, True
    causes = commission(study)
    _keep(causes, path)
    return causes, False


def _folder() -> Path:
    return user_cache_path("bigant", appauthor=False) / FOLDER


def _digest(study: Study) -> str:
    digest = hashlib.sha256(f"{program_digest()} {study.local.value}".encode())
    references = study.predictor.trials[len(study.trials) :]
    for trial in references:
        digest.update(f"{trial.header!r}".encode())
        for part in bytes_of(arrays_of(trial)):
            digest.update(part)
    return digest.hexdigest()[:32]


@cache
def program_digest() -> str:
    """Return a digest of the sources that a baseline is computed by."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        with as_file(files(package)) as folder:
            for path in sorted(folder.rglob("*.py")):
                digest.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def _read(path: Path) -> tuple[Cause, ...] | None:
    """Return what is kept; None if there is nothing, or nothing that can be read."""
    try:
        return read_causes(path)
    except (OSError, ValueError):
        return None


def _keep(causes: Sequence[Cause], path: Path) -> None:
    """A cache that cannot be written is none."""
    with suppress(OSError, RecordError), earlier_files(overwrite=True, notify=lambda _: None):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_causes(causes, path)
