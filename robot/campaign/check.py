"""``bigant gap check``: diagnose a campaign whose causes are withheld, then open the seal and count."""

from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import replace
from math import nan

from gap.check.cases import REMOVED, SINGLE, CheckedCase
from gap.check.methods import methods
from gap.check.score import confusions, figures
from gap.worker_pool import worker_pool
from model.errors import ConfigError, GapError, RecordError
from record.trial.header_file import read_text
from record.whole_file import write_text
from robot.campaign.case import (
    CaseFiles,
    CaseRequest,
    Label,
    answer_case,
    campaign_cases,
    commission_case,
    parse_labels,
    read_answer,
    read_case,
)
from robot.campaign.plan import campaign_reality, read_scenario
from robot.campaign.score_text import score_lines, score_markdown
from robot.campaign.seal import OPEN_NAME, SEALED_NAME, read_key, unseal
from robot.campaign.visible import Visibility, measure_visibility
from robot.console.exit_codes import ExitCode
from robot.console.json_output import check_json, give_json, to_stdout
from robot.console.progress import ProgressBar
from robot.requests.gap import GapCheckRequest

STANDING = "standing.json"


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
    blind = [CaseRequest(one.trials, one.references, out / f"{one.name}.json") for one in files]
    answer_all(blind, request.jobs, "cases")
    labels = _labels(request, files)
    to_score = [(one.name, labels[one.name].kind, out / f"{one.name}.json") for one in files]
    single = [one for one in files if labels[one.name].kind == SINGLE][: request.removed]
    removed = [(one.name, REMOVED, out / f"{one.name}-removed.json") for one in single]
    without_effect = [
        CaseRequest(
            one.trials, one.references, answer, tuple(t.effect for t in labels[one.name].truths)
        )
        for one, (_, _, answer) in zip(single, removed, strict=True)
    ]
    answer_all(without_effect, request.jobs, "without their effect")
    standing = commission_case(blind[0], out / STANDING) if blind[0].references else ()
    reality = campaign_reality(request.campaign)
    scenario = None if request.scenario is None else read_scenario(request.scenario, reality)
    visible = measure_visibility(files, labels, scenario, out, request.jobs, standing)
    unknown = Visibility(nan, nan)
    cases = [
        CheckedCase(
            name, kind, labels[name].truths, read_answer(answer), *visible.get(name, unknown)
        )
        for name, kind, answer in (*to_score, *removed)
    ]
    _, simulator = read_case(files[0].trials[:1])
    neutral = {(e.name, p.name): p.neutral for e in simulator.effects for p in e.parameters}
    counted, confused = figures(cases, neutral), confusions(cases)
    if not to_stdout(request.json):
        print("\n".join(score_lines(counted, confused, cases)))
    whole = {"figures": counted, "confusions": confused, "methods": methods(cases), "cases": cases}
    give_json(whole, request.json, indent=1)
    if request.markdown is not None:
        write_text(request.markdown, score_markdown(counted, confused, cases), "--markdown")
    missed = any(figure.met is False for figure in counted)
    return ExitCode.VERDICT_FAILED if missed else ExitCode.OK


def answer_all(requests: Sequence[CaseRequest], jobs: int, words: str) -> None:
    """Diagnose what has no answer yet, several cases at a time; one that fails does not stop the others.

    Raises:
        GapError: Some got no answer.
    """
    left = [one for one in requests if not one.out.is_file()]
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
