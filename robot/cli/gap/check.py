"""``bigant gap check``: diagnose a campaign whose causes are withheld, then open the seal and count.

Each case is diagnosed with the campaign's healthy runs and its answer kept in --out, before any label is
looked at; cases answered already are not asked again. Then the labels are opened (labels.json, or the
sealed ones with --key), and every figure of the protocol is printed with its bar, and the confusions. With
--removed N, the first N single-effect cases are diagnosed once more with their true effect taken out of
the catalogue. How visible each effect is, and what its true values would close, are measured: against the
campaign's controls, or with --scenario against walks of the twin without the effects. Exit code 1: some
bar is not met.
"""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode
from robot.console.json_output import add_json, check_json, give_json, to_stdout

STANDING = "standing.json"

if TYPE_CHECKING:
    from gap.check.score import Case, Figure
    from robot.campaign.case import Asked
    from robot.campaign.folder import CaseFiles, Label


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument(
        "campaign", type=Path, metavar="CAMPAIGN", help="folder of bigant sim campaign"
    )
    parser.add_argument("--key", type=Path, metavar="FILE", help="key of the sealed labels")
    parser.add_argument("--scenario", type=Path, metavar="FILE",
        help="its scenario file: the twin walks each case again to tell what is visible")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR",
        help="where answers are kept (default: CAMPAIGN/answers)")  # fmt: skip
    parser.add_argument("--removed", type=int, default=0, metavar="N",
        help="single-effect cases to diagnose again without their effect in the catalogue")  # fmt: skip
    parser.add_argument("--no-references", action="store_true", help="leave the healthy runs aside")
    parser.add_argument("--jobs", type=int, default=min(os.cpu_count() or 1, 4), metavar="N",
        help="cases at a time (default: one a core, up to 4)")  # fmt: skip
    add_json(parser, "figures and cases")
    parser.add_argument(
        "--markdown", type=Path, metavar="FILE", help="figures as tables for a page"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Diagnose, open the seal, count.

    Raises:
        RecordError: The folder holds no campaign, or a file cannot be read or written.
        ConfigError: Options that make no sense, or a wrong key.
    """
    from gap.check.score import confusions, figures
    from model.errors import ConfigError
    from robot.campaign.case import neutral_values
    from robot.campaign.folder import campaign_cases
    from robot.campaign.score_text import score_json, score_lines, score_markdown

    if options.jobs < 1 or options.removed < 0:
        raise ConfigError("--jobs and --removed", "must not be negative, and --jobs at least 1")
    check_json(options.json)
    files = campaign_cases(options.campaign)
    out: Path = options.out or options.campaign / "answers"
    answer_all(_blind(files, out, references=not options.no_references), options.jobs, "cases")
    labels = _labels(options, files)
    removed = _without(files, labels, out, options)
    answer_all(removed, options.jobs, "without their effect")
    cases = _cases(files, labels, removed, out, options)
    counted = figures(cases, neutral_values(files[0]))
    confused = confusions(cases)
    if not to_stdout(options.json):
        print("\n".join(score_lines(counted, confused, cases)))
    if options.json is not None:
        give_json(score_json(counted, confused, cases), options.json, indent=1)
    if options.markdown is not None:
        _write(options.markdown, score_markdown(counted, confused, cases))
    return ExitCode.VERDICT_FAILED if _missed(counted) else ExitCode.OK


def _write(path: Path, text: str) -> None:
    from model.errors import RecordError

    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror}") from error


def _missed(counted: "tuple[Figure, ...]") -> bool:
    return any(figure.met is False for figure in counted)


def _blind(files: "tuple[CaseFiles, ...]", out: Path, *, references: bool) -> "list[Asked]":
    from robot.campaign.case import Asked

    return [
        Asked(one.trials, one.references if references else (), (), out / f"{one.name}.json")
        for one in files
    ]


def _without(
    files: "tuple[CaseFiles, ...]",
    labels: "dict[str, Label]",
    out: Path,
    options: argparse.Namespace,
) -> "list[Asked]":
    from gap.check.score import SINGLE
    from robot.campaign.case import Asked

    single = [one for one in files if labels[one.name].kind == SINGLE]
    return [
        Asked(
            one.trials,
            () if options.no_references else one.references,
            tuple(truth.effect for truth in labels[one.name].truths),
            out / f"{one.name}-removed.json",
        )
        for one in single[: options.removed]
    ]


def answer_all(asked: "list[Asked]", jobs: int, words: str) -> None:
    """Diagnose what has no answer yet, several cases at a time; one that fails does not stop the others.

    Raises:
        GapError: Some got no answer.
    """
    from concurrent.futures import as_completed
    from dataclasses import replace

    from gap.worker_pool import worker_pool
    from model.errors import GapError
    from robot.campaign.case import answer_case, commission_case
    from robot.console.progress import ProgressBar

    left = [one for one in asked if not one.out.is_file()]
    if not left:
        return
    left[0].out.parent.mkdir(parents=True, exist_ok=True)
    with worker_pool(jobs) as pool, ProgressBar(words) as bar:
        standing = None
        if left[0].references:
            bar.show(0.0, "what the healthy runs lack")
            kept = left[0].out.parent / STANDING
            standing = pool.submit(commission_case, left[0], kept).result()
        left = [replace(one, standing=standing) for one in left]
        running = {pool.submit(answer_case, one): one.out.stem for one in left}
        failed = []
        for number, done in enumerate(as_completed(running)):
            if (error := done.exception()) is not None:
                failed.append(f"{running[done]}: {error!r}")
            bar.show((number + 1) / len(left), f"{number + 1} of {len(left)}")
    if failed:
        raise GapError(
            f"{len(failed)} of {len(left)} {words} got no answer ({'; '.join(failed)}); the other answers "
            f"are kept in {left[0].out.parent}, and the same command goes on from there"
        )


def _labels(options: argparse.Namespace, files: "tuple[CaseFiles, ...]") -> "dict[str, Label]":
    from model.errors import ConfigError, RecordError
    from robot.campaign.folder import parse_labels
    from robot.campaign.seal import OPEN_NAME, SEALED_NAME, read_key, unseal

    plain: Path = options.campaign / OPEN_NAME
    if (options.campaign / SEALED_NAME).exists():
        if options.key is None:
            raise ConfigError(
                "--key", "the labels are sealed; all cases are answered, now give the key"
            )
        labels = parse_labels(unseal(options.campaign, read_key(options.key)).text, SEALED_NAME)
    else:
        try:
            labels = parse_labels(plain.read_text(encoding="utf-8"), str(plain))
        except OSError as error:
            raise RecordError(f"{plain} cannot be read: {error.strerror}") from error
    unknown = [one.name for one in files if one.name not in labels]
    if unknown:
        raise RecordError(f"{', '.join(unknown)}: no label; the labels are of another campaign")
    return labels


def _cases(
    files: "tuple[CaseFiles, ...]",
    labels: "dict[str, Label]",
    removed: "list[Asked]",
    out: Path,
    options: argparse.Namespace,
) -> "list[Case]":
    from math import nan

    from gap.check.score import REMOVED, Case
    from robot.campaign.case import Asked, commission_case
    from robot.campaign.folder import read_answer
    from robot.campaign.visible import Seen, seen_of

    asked = Asked(files[0].trials, files[0].references, (), out / files[0].name)
    use_references = bool(files[0].references) and not options.no_references
    standing = commission_case(asked, out / STANDING) if use_references else ()
    seen = seen_of(files, labels, options.scenario, out, options.jobs, standing)
    cases = []
    for one in files:
        label, known = labels[one.name], seen.get(one.name, Seen(nan, nan))
        answer = read_answer(out / f"{one.name}.json")
        cases.append(
            Case(one.name, label.kind, label.truths, answer, known.visible, known.reachable)
        )
    for asked in removed:
        name = asked.out.stem.removesuffix("-removed")
        known = seen.get(name, Seen(nan, nan))
        answer = read_answer(asked.out)
        cases.append(
            Case(name, REMOVED, labels[name].truths, answer, known.visible, known.reachable)
        )
    return cases
