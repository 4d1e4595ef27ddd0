"""The answer of ``bigant gap diagnose`` to each case, in a process of its own, kept as JSON."""

import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from benchmarks.gap.apart.cases import REFERENCE_RUNS, WITHOUT_REFERENCES, Case
from benchmarks.gap.apart.files import run_file
from robot.gap_report.kept_baseline import program_digest

ANSWERS, PROGRAM = "answers", "program.txt"
CHECKOUT = Path(__file__).resolve().parents[3]
LIMIT_S = 1800.0  # twenty times what a case takes


@dataclass(frozen=True, slots=True)
class Question:
    """A diagnosis to be made: of a case, with the six references or without any."""

    case: Case
    referenced: bool = True

    @property
    def name(self) -> str:
        """Of its answer, without suffix."""
        return self.case.name if self.referenced else f"{self.case.name}_without_references"


def questions_of(cases: Sequence[Case]) -> tuple[Question, ...]:
    """Return the diagnoses of cases: each with references, three of them without as well."""
    without = [one for one in cases if one.name in WITHOUT_REFERENCES]
    return (*map(Question, cases), *(Question(one, referenced=False) for one in without))


def answer_file(out: Path, question: Question) -> Path:
    """Return where an answer is or will be."""
    return out / ANSWERS / f"{question.name}.json"


def answer_all(
    out: Path, questions: Sequence[Question], jobs: int, tell: Callable[[str], None]
) -> None:
    """Diagnose what has no answer yet; what the command prints is kept beside it.

    Args:
        out: Folder of everything.
        questions: Diagnoses to be there in the end; one that fails stays without an answer.
        jobs: Diagnoses at a time.
        tell: Gets a line about each that is done.

    Raises:
        SystemExit: There are answers of another version of the diagnosis.
    """
    _check_program(out / ANSWERS)
    left = [one for one in questions if not answer_file(out, one).is_file()]
    pool = ThreadPoolExecutor(jobs)
    try:
        running = {pool.submit(_answer, out, one): one for one in left}
        for number, done in enumerate(as_completed(running), 1):
            tell(f"{running[done].name}: {done.result()} ({number} of {len(left)})")
    finally:  # when interrupted, none of those that wait is begun
        pool.shutdown(cancel_futures=True)


def _answer(out: Path, question: Question) -> str:
    """Diagnose a case, and say how it went."""
    answer = answer_file(out, question)
    trials = [run_file(out, run) for run in question.case.runs]
    healthy = [run_file(out, run) for run in REFERENCE_RUNS] if question.referenced else []
    command: list[str | Path] = [sys.executable, "-m", "bigant", "gap", "diagnose", *trials]
    if healthy:
        command += ["--reference", *healthy]
    command += ["--jobs", "1", "--overwrite", "--json", answer]
    with answer.with_suffix(".txt").open("w", encoding="utf-8") as printed:
        try:
            # from the checkout of this benchmark, so that its own engine is judged
            subprocess.run(
                command, cwd=CHECKOUT, stdout=printed, stderr=subprocess.STDOUT, timeout=LIMIT_S
            )
        except subprocess.TimeoutExpired:
            return f"no answer in {LIMIT_S:.0f} s"
    return "answered" if answer.is_file() else f"no answer; see {answer.with_suffix('.txt')}"


def _check_program(folder: Path) -> None:
    """Keep answers of two versions of the diagnosis out of one table."""
    folder.mkdir(parents=True, exist_ok=True)
    path, digest = folder / PROGRAM, program_digest()
    if any(folder.glob("*.json")) and path.is_file() and path.read_text("utf-8") != digest:
        raise SystemExit(
            f"{folder} has answers of another version of the diagnosis; name another --out, or move "
            "them away"
        )
    path.write_text(digest, encoding="utf-8")
