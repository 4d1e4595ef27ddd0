"""``bigant campaign score --realities``: a campaign of each reality, one row each, worst named.

Constants of the probabilities are fitted on all realities but one and judged on that one, each in turn.
"""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TypeVar

from gap.check.calibration import LeftOut, leave_one_out
from gap.check.cases import CheckedCase
from gap.check.evidence_rows import cause_prior, cause_rows, none_prior, none_rows
from gap.check.realities import (
    RealityFigures,
    figures_alone,
    figures_of_reality,
    worst_reality,
)
from gap.check.score import confusions
from model.errors import RecordError
from record.whole_file import write_text
from robot.campaign.answers import (
    STANDING,
    answer_each,
    answer_removed,
    answers_folder,
    blind_requests,
    checked_cases,
    files_of,
    read_labels,
)
from robot.campaign.case import CASES, baseline_of_case
from robot.campaign.plan import campaign_reality
from robot.campaign.reality_text import reality_lines, reality_markdown
from robot.console.exit_codes import ExitCode
from robot.console.json_output import give_json, to_stdout
from robot.console.program_output import complain
from robot.requests.campaign import CampaignScoreRequest
from sim_hw.realities.own_effects import own_effects

ALL = "all"  # the row of all realities together
Part = TypeVar("Part")
Cases = Mapping[str, Sequence[CheckedCase]]
Crashed = Mapping[str, Mapping[str, BaseException]]


def check_realities(request: CampaignScoreRequest, executor: Executor) -> ExitCode:
    """Diagnose all campaigns of a folder, open their seals, count each for itself.

    Raises:
        RecordError: The folder holds no campaigns, or a file cannot be read or written.
        ConfigError: A wrong key, or none for sealed labels.
    """
    folders = _campaigns(request.campaign)
    crashed = {}
    for name, folder in folders.items():  # all before any label is looked at
        files = files_of(folder, no_references=request.no_references)
        failed = answer_each(blind_requests(files, _out(request, folder)), executor, name)
        crashed[name] = dict(failed)
    cases = {
        name: _counted(request, folder, crashed[name], executor) for name, folder in folders.items()
    }
    rows, together = (
        _alone(request, cases, crashed) if request.no_references else _rows(cases, crashed)
    )
    none = leave_one_out({name: none_rows(own) for name, own in cases.items()}, none_prior())
    cause = leave_one_out({name: cause_rows(own) for name, own in cases.items()}, cause_prior())
    _give(request, rows, together, (none, cause), cases, crashed)
    missed = any(row.missed for row in rows)
    return ExitCode.VERDICT_FAILED if missed else ExitCode.OK


def _give(
    request: CampaignScoreRequest,
    rows: Sequence[RealityFigures],
    together: RealityFigures,
    left_out: tuple[Sequence[LeftOut], Sequence[LeftOut]],
    cases: Cases,
    crashed: Crashed,
) -> None:
    worst, confused = worst_reality(rows), {name: confusions(own) for name, own in cases.items()}
    if not to_stdout(request.json):
        print("\n".join(reality_lines(rows, together, worst, left_out, confused)))
        for name, failed in crashed.items():
            for case, error in failed.items():
                print(f"  {name} {case} got no answer: {error!r}")
    whole = {
        "realities": rows,
        "together": together,
        "worst": worst.name,
        "left_out": {"none_of_these": left_out[0], "causes": left_out[1]},
        "confusions": confused,
        "crashed": {n: {c: repr(e) for c, e in failed.items()} for n, failed in crashed.items()},
        "cases": cases,
    }
    give_json(whole, request.json, indent=1)
    if request.markdown is not None:
        write_text(
            request.markdown, reality_markdown(rows, together, worst, left_out), "--markdown"
        )


def _campaigns(folder: Path) -> dict[str, Path]:
    folders = {path.parent.name: path.parent for path in sorted(folder.glob(f"*/{CASES}"))}
    if not folders:
        raise RecordError(
            f"{folder} holds no campaigns (NAME/{CASES}); "
            "make them with: bigant campaign make --reality all"
        )
    return folders


def _rows(cases: Cases, crashed: Crashed) -> tuple[list[RealityFigures], RealityFigures]:
    """Count each reality, and all together."""
    rows = [figures_of_reality(name, own, tuple(crashed[name])) for name, own in cases.items()]
    return rows, figures_of_reality(ALL, _joined(cases), _joined(crashed))


def _alone(
    request: CampaignScoreRequest, cases: Cases, crashed: Crashed
) -> tuple[list[RealityFigures], RealityFigures]:
    """Count answers without references against what each reality's healthy robots have and show."""
    known: dict[str, list[tuple[CheckedCase, set[str] | None]]] = {}
    for name, own in cases.items():
        folder = request.campaign / name
        first = blind_requests(files_of(folder, no_references=False), folder)[0]
        causes = baseline_of_case(first, _out(request, folder) / STANDING)
        if causes is None:
            complain(
                f"{name}: its references are too few to show a baseline (two gaits or frequencies are "
                "needed), so its healthy robots are not judged"
            )
        built_so = own_effects(campaign_reality(folder))
        baseline = None if causes is None else {one.effect for one in causes} | built_so
        known[name] = [(case, baseline) for case in own]
    rows = [figures_alone(name, own, tuple(crashed[name])) for name, own in known.items()]
    return rows, figures_alone(ALL, _joined(known), _joined(crashed))


def _joined(parts: Mapping[str, Iterable[Part]]) -> list[Part]:
    return [one for own in parts.values() for one in own]


def _out(request: CampaignScoreRequest, folder: Path) -> Path:
    if request.out is not None:
        return request.out / folder.name
    return answers_folder(folder, no_references=request.no_references)


def _counted(
    request: CampaignScoreRequest, folder: Path, crashed: Mapping[str, object], executor: Executor
) -> list[CheckedCase]:
    """Open the labels of one campaign and put its answers beside them."""
    every = files_of(folder, no_references=request.no_references)
    files = [one for one in every if one.name not in crashed]
    labels, out = read_labels(folder, request.key, every), _out(request, folder)
    answers = [(one.name, labels[one.name].kind, out / f"{one.name}.json") for one in files]
    answers += answer_removed(files, labels, out, request.removed, executor)
    return checked_cases(answers, labels, {})
