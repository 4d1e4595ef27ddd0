"""The page of a log: the replay and one sentence, then the curves, then the numbers in groups."""

from model.compiled import few_calls
from record.log.recording import Recording
from robot.report.page import Section, report_page
from robot.report.pictures import pictures
from robot.report.plots import draw_log
from robot.report.replay import replay_of
from robot.report.run_date import date_words
from robot.report.summary import Summary
from robot.report.summary_text import run_facts, run_sentence, summary_groups


def walk_page(summary: Summary, log: Recording, source: str) -> str:
    """Return the page of a log from a ``source``; without a replay where no robot is known."""
    robot = log.metadata.get("robot", "Robot")
    software = log.metadata.get("software", "written by an unknown program")
    with few_calls():  # a few thousand poses of the legs
        replay = replay_of(log)
    curves = pictures(draw_log(log))
    path, others = curves[:1], curves[1:]
    rest = [*others, *path] if replay else others
    groups = summary_groups(summary)
    return report_page(
        f"{robot}: {summary.gait}",
        f"{source}, {date_words(log.metadata)}, {software}",
        [
            Section("", facts=run_facts(summary)),
            *rest,
            *(Section(title, rows) for title, rows in groups.items()),
        ],
        lead=replay or path[0].picture,
        verdict=run_sentence(summary),
    )
