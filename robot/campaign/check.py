"""``bigant gap check``: diagnose a campaign whose causes are withheld, then open the seal and count."""

from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import replace
from math import nan
from pathlib import Path

from gap.check.score import REMOVED, SINGLE, Case, confusions, figures
from gap.worker_pool import worker_pool
from model.errors import ConfigError, GapError, RecordError
from record.trial.header import read_text
from record.whole_file import write_text
from robot.campaign.case import Asked, answer_case, commission_case, neutral_values
from robot.campaign.folder import CaseFiles, Label, campaign_cases, parse_labels, read_answer
from robot.campaign.score_text import score_json, score_lines, score_markdown
from robot.campaign.seal import OPEN_NAME, SEALED_NAME, read_key, unseal
from robot.campaign.visible import Seen, seen_of
from robot.console.exit_codes import ExitCode
from robot.console.json_output import check_json, give_json, to_stdout
from robot.console.progress import ProgressBar
from robot.requests.gap import GapCheckRequest

STANDING = "standing.json"
NOT_SEEN = Seen(nan, nan)


def check_campaign(request: GapCheckRequest) -> ExitCode:
    """Diagnose, open the seal, count.

    Raises:
        RecordError: The folder holds no campaign, or a file cannot be read or written.
        ConfigError: Options that make no sense, or a wrong key.
    """
    if request.jobs < 1 or request.removed < 0:
        raise ConfigError("--jobs and --removed", "must not be negative, and --jobs at least 1")
    check_json(request.json)
    files = campaign_cases(request.campaign)
    if request.no_references:
        files = tuple(replace(one, references=()) for one in files)
    out = request.out or request.campaign / "answers"
    blind = [Asked(one.trials, one.references, (), out / f"{one.name}.json") for one in files]
    answer_all(blind, request.jobs, "cases")
    labels = _labels(request, files)
    single = [one for one in files if labels[one.name].kind == SINGLE][: request.removed]
    removed = {
        one.name: Asked(
            one.trials,
            one.references,
            tuple(truth.effect for truth in labels[one.name].truths),
            out / f"{one.name}-removed.json",
        )
        for one in single
    }
    answer_all(list(removed.values()), request.jobs, "without their effect")
    standing = commission_case(blind[0], out / STANDING) if blind[0].references else ()
    seen = seen_of(files, labels, request.scenario, out, request.jobs, standing)
    asked = [
        (one.name, labels[one.name].kind, of.out) for one, of in zip(files, blind, strict=True)
    ]
    asked += [(name, REMOVED, of.out) for name, of in removed.items()]
    cases = [_case(name, kind, answer, labels, seen) for name, kind, answer in asked]
    counted, confused = figures(cases, neutral_values(files[0])), confusions(cases)
    if not to_stdout(request.json):
        print("\n".join(score_lines(counted, confused, cases)))
    give_json(score_json(counted, confused, cases), request.json, indent=1)
    if request.markdown is not None:
        write_text(request.markdown, score_markdown(counted, confused, cases), "--markdown")
    missed = any(figure.met is False for figure in counted)
    return ExitCode.VERDICT_FAILED if missed else ExitCode.OK


def _case(
    name: str, kind: str, answer: Path, labels: Mapping[str, Label], seen: Mapping[str, Seen]
) -> Case:
    known = seen.get(name, NOT_SEEN)
    truths = labels[name].truths
    return Case(name, kind, truths, read_answer(answer), known.visible, known.reachable)


def answer_all(asked: Sequence[Asked], jobs: int, words: str) -> None:
    """Diagnose what has no answer yet, several cases at a time; one that fails does not stop the others.

    Raises:
        GapError: Some got no answer.
    """
    left = [one for one in asked if not one.out.is_file()]
    if not left:
        return
    folder = left[0].out.parent
    folder.mkdir(parents=True, exist_ok=True)
    with worker_pool(jobs) as pool, ProgressBar(words) as bar:
        standing = None
        if left[0].references:
            bar.show(0.0, "baseline model errors of the healthy runs")
            standing = pool.submit(commission_case, left[0], folder / STANDING).result()
        running = {
            pool.submit(answer_case, replace(one, standing=standing)): one.out.stem for one in left
        }
        failed = []
        for number, done in enumerate(as_completed(running), 1):
            if (error := done.exception()) is not None:
                failed.append(f"{running[done]}: {error!r}")
            bar.show(number / len(left), f"{number} of {len(left)}")
    if failed:
        raise GapError(
            f"{len(failed)} of {len(left)} {words} got no answer ({'; '.join(failed)}); the other answers "
            f"are kept in {folder}, and the same command goes on from there"
        )


def _labels(request: GapCheckRequest, files: Sequence[CaseFiles]) -> dict[str, Label]:
    folder, plain = request.campaign, request.campaign / OPEN_NAME
    if (folder / SEALED_NAME).exists():
        if request.key is None:
            raise ConfigError(
                "--key", "the labels are sealed; all cases are answered, now give the key"
            )
        labels = parse_labels(unseal(folder, read_key(request.key)).text, SEALED_NAME)
    else:
        labels = parse_labels(read_text(plain), str(plain))
    unknown = [one.name for one in files if one.name not in labels]
    if unknown:
        raise RecordError(f"{', '.join(unknown)}: no label; the labels are of another campaign")
    return labels
