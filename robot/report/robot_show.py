"""``bigant robot show``: a robot file as the model walks it, and what is wrong with it."""

import sys

from gaits.catalog import make_gait
from record.whole_file import check_room, write_text
from robot.config.gait_file import with_gait
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.installed import version_lines
from robot.console.json_output import print_json
from robot.console.screen_fit import columns_of
from robot.design.concern import Severity
from robot.design.review import RobotReview, review_robot
from robot.design.standing import STANDING
from robot.report.page import Section
from robot.report.robot_text import (
    assumed_words,
    figure_rows,
    review_json,
    review_lines,
    robot_rows,
)
from robot.requests.robot import RobotShowRequest


def show_robot(request: RobotShowRequest) -> ExitCode:
    """Review a robot file, print it, and draw it where a page is asked for.

    Returns:
        OK, or VERDICT_FAILED where the review has a warning.

    Raises:
        ConfigError: The robot file cannot be used, or there is no such gait.
        RecordError: The page cannot be written.
    """
    check_room(request.out, "--out", ".html", ".png")
    config = load_robot(request.robot, driven=False)
    gaits = None
    if request.gait is not None:
        config, name = with_gait(config, request.gait)
        gaits = [make_gait(name, config.parameters)]
    review = review_robot(config, gaits)
    if request.json:
        print_json(review_json(review))
    else:
        print("\n".join(review_lines(review, columns_of(sys.stdout))))
    if request.out is not None:
        written = _write_page(request, review)
        if not request.json:
            print(f"page: {written}")
    return ExitCode.VERDICT_FAILED if review.warnings else ExitCode.OK


def _write_page(request: RobotShowRequest, review: RobotReview) -> str:
    from robot.report.gait_replay import drawn_gaits, gait_replay
    from robot.report.page import report_page
    from robot.report.pictures import write_report
    from robot.report.robot_figures import draw_review

    assert request.out is not None
    figures = draw_review(review)
    if request.out.suffix == ".png":
        return ", ".join(map(str, write_report(request.out, "", "", (), figures)))
    worst = review.warnings[0] if review.warnings else None
    kind = {None: "pass", Severity.WARNING: "warn", Severity.IMPOSSIBLE: "fail"}
    marks = {Severity.NOTE: "note", Severity.WARNING: "warn", Severity.IMPOSSIBLE: "fail"}
    concerns = [
        (marks[one.severity], f"{one.place}: {one.topic}", one.reason, one.advice)
        for one in review.concerns
    ]
    names = [one.figures.gait for one in review.gaits]
    moves = "stands" if names == [STANDING] else "walks"
    verdict = f"It {moves}, as far as the model can tell." if worst is None else (
        f"{len(review.warnings)} warning{'s' if len(review.warnings) > 1 else ''}: "
        f"{', '.join(dict.fromkeys(f'{one.place} {one.topic}' for one in review.warnings))}."
    )  # fmt: skip
    replays = [gait_replay(review.config.parameters, one) for one in review.gaits]
    page = report_page(
        review.config.name,
        f"robot file {request.robot.name}, walked through the quasi-static model",
        [
            Section("What to look at", concerns, ("", "where", "what", "what to do")),
            *drawn_gaits(review, figures, replays[1:]),
            Section("Gaits", figure_rows(review), ("", *names), range(1, len(names) + 1)),
            Section("Sizes", robot_rows(review)),
            Section("Assumed", [("", assumed_words(review))]),
        ],
        lead=replays[0] if replays else None,
        verdict=verdict,
        kind=kind[None if worst is None else worst.severity],
        footer=version_lines()[0],
    )
    write_text(request.out, page)
    return str(request.out)
