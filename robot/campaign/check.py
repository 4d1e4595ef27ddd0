"""``bigant campaign score``: diagnose blind campaigns, then open the seals and count."""

from concurrent.futures import Executor

from gap.check.methods import methods
from gap.check.score import confusions, figures
from model.errors import ConfigError
from record.whole_file import write_text
from robot.campaign.answers import (
    STANDING,
    answer_all,
    answer_removed,
    answers_folder,
    blind_requests,
    checked_cases,
    files_of,
    read_labels,
)
from robot.campaign.case import commission_case, read_case
from robot.campaign.executor import campaign_executor
from robot.campaign.plan import campaign_reality, read_scenario
from robot.campaign.realities import check_realities
from robot.campaign.score_text import score_lines, score_markdown
from robot.campaign.visible import measure_visibility
from robot.console.exit_codes import ExitCode
from robot.console.json_output import check_json, give_json, to_stdout
from robot.requests.campaign import CampaignScoreRequest


def check_campaign(request: CampaignScoreRequest) -> ExitCode:
    """Diagnose, open the seal, count.

    Raises:
        RecordError: The folder holds no campaign, or a file cannot be read or written.
        ConfigError: Options that make no sense, or a wrong key.
    """
    if request.jobs < 1 or request.removed < 0:
        raise ConfigError("--jobs and --removed", "must not be negative, and --jobs at least 1")
    check_json(request.json)
    if request.realities and request.scenario is not None:
        raise ConfigError(
            "--scenario", "is for one campaign; check it alone to measure what is visible in it"
        )
    with campaign_executor(request.jobs, request.dask) as executor:
        if request.realities:
            return check_realities(request, executor)
        return _check_one(request, executor)


def _check_one(request: CampaignScoreRequest, executor: Executor) -> ExitCode:
    files = files_of(request.campaign, no_references=request.no_references)
    reality = campaign_reality(request.campaign)
    scenario = None if request.scenario is None else read_scenario(request.scenario, reality)
    out = request.out or answers_folder(request.campaign, no_references=request.no_references)
    blind = blind_requests(files, out)
    answer_all(blind, executor, "cases")
    labels = read_labels(request.campaign, request.key, files)
    answers = [(one.name, labels[one.name].kind, out / f"{one.name}.json") for one in files]
    answers += answer_removed(files, labels, out, request.removed, executor)
    standing = commission_case(blind[0], out / STANDING) if blind[0].references else ()
    visible = measure_visibility(files, labels, scenario, out, executor, standing)
    cases = checked_cases(answers, labels, visible)
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
