"""The diagnoses of a campaign, made blind, and its labels, opened after them."""

from collections.abc import Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import replace
from pathlib import Path

from gap.check.cases import REMOVED, SINGLE, CheckedCase
from model.errors import BigantError, ConfigError, GapError, RecordError
from record.trial.header_file import read_text
from robot.campaign.case import (
    CaseFiles,
    CaseRequest,
    Label,
    answer_case,
    campaign_cases,
    commission_case,
    parse_labels,
    read_answer,
)
from robot.campaign.seal import OPEN_NAME, SEALED_NAME, read_key, unseal
from robot.campaign.visible import UNKNOWN, Visibility
from robot.console.progress import ProgressBar

STANDING = "standing.json"
ANSWERS, ANSWERS_ALONE = "answers", "answers_without_references"


def files_of(folder: Path, *, no_references: bool) -> tuple[CaseFiles, ...]:
    """Return the cases of a campaign, without their references if so asked.

    Raises:
        RecordError: The folder holds no campaign.
    """
    files = campaign_cases(folder)
    return tuple(replace(one, references=()) for one in files) if no_references else files


def answers_folder(campaign: Path, *, no_references: bool) -> Path:
    """Return where answers are kept by default: those without references apart from the others."""
    return campaign / (ANSWERS_ALONE if no_references else ANSWERS)


def blind_requests(files: Sequence[CaseFiles], out: Path) -> list[CaseRequest]:
    """Return the diagnoses to be made before any label is looked at."""
    return [CaseRequest(one.trials, one.references, out / f"{one.name}.json") for one in files]


def answer_all(requests: Sequence[CaseRequest], executor: Executor, words: str) -> None:
    """Diagnose what has no answer yet, several cases at a time; one that fails does not stop the others.

    Raises:
        GapError: Some got no answer.
    """
    failed = [f"{name}: {error!r}" for name, error in answer_each(requests, executor, words)]
    if failed:
        folder = requests[0].out.parent
        raise GapError(
            f"{len(failed)} of {len(requests)} {words} got no answer ({'; '.join(failed)}); the other "
            f"answers are kept in {folder}, and the same command goes on from there"
        )


def answer_each(
    requests: Sequence[CaseRequest], executor: Executor, words: str
) -> list[tuple[str, BaseException]]:
    """Diagnose what has no answer yet; return the names of cases that got none, each with the reason."""
    left = [one for one in requests if not one.out.is_file()]
    if not left:
        return []
    folder = left[0].out.parent
    folder.mkdir(parents=True, exist_ok=True)
    failed: list[tuple[str, BaseException]] = []
    with ProgressBar(words) as bar:
        standing = None
        if left[0].references:
            bar.show(0.0, "baseline model errors of the healthy runs")
            try:
                standing = executor.submit(commission_case, left[0], folder / STANDING).result()
            except BigantError as fault:  # with these references no case gets an answer
                return [(one.out.stem, fault) for one in left]
        running = {
            executor.submit(answer_case, replace(one, standing=standing)): one.out.stem
            for one in left
        }
        for number, done in enumerate(as_completed(running), 1):
            if (error := done.exception()) is not None:
                failed.append((running[done], error))
            bar.show(number / len(left), f"{number} of {len(left)}")
    return failed


def answer_removed(
    files: Sequence[CaseFiles],
    labels: dict[str, Label],
    out: Path,
    count: int,
    executor: Executor,
) -> list[tuple[str, str, Path]]:
    """Diagnose the first single-effect cases again without their effect; name, kind, answer of each.

    Raises:
        GapError: Some got no answer.
    """
    single = [one for one in files if labels[one.name].kind == SINGLE][:count]
    removed = [(one.name, REMOVED, out / f"{one.name}-removed.json") for one in single]
    requests = [
        CaseRequest(
            one.trials, one.references, answer, tuple(t.effect for t in labels[one.name].truths)
        )
        for one, (_, _, answer) in zip(single, removed, strict=True)
    ]
    answer_all(requests, executor, "without their effect")
    return removed


def checked_cases(
    answers: Sequence[tuple[str, str, Path]],
    labels: dict[str, Label],
    visible: dict[str, Visibility],
) -> list[CheckedCase]:
    """Put answers (name, kind, file) beside what was wrong.

    Raises:
        RecordError: An answer cannot be read.
    """
    return [
        CheckedCase(
            name, kind, labels[name].truths, read_answer(answer), *visible.get(name, UNKNOWN)
        )
        for name, kind, answer in answers
    ]


def read_labels(folder: Path, key: Path | None, files: Sequence[CaseFiles]) -> dict[str, Label]:
    """Open the labels of a campaign.

    Raises:
        RecordError: They cannot be read, or are of another campaign.
        ConfigError: They are sealed, and there is no key or a wrong one.
    """
    plain = folder / OPEN_NAME
    if (folder / SEALED_NAME).exists():
        if key is None:
            raise ConfigError(
                "--key", "the labels are sealed; all cases are answered, now give the key"
            )
        labels = parse_labels(unseal(folder, read_key(key)).text, SEALED_NAME)
    else:
        labels = parse_labels(read_text(plain), str(plain))
    unknown = [one.name for one in files if one.name not in labels]
    if unknown:
        raise RecordError(f"{', '.join(unknown)}: no label; the labels are of another campaign")
    return labels
