"""``bigant report``: one page and one table of a day's runs."""

import sys
from pathlib import Path

from record.whole_file import check_room, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar, StatusLine
from robot.console.screen_fit import terminal_width
from robot.day.gap import DayGap, gap_of_day
from robot.day.runs import DayRun, logs_of, read_runs_of_day, references_of
from robot.day.text import day_lines, day_sentence
from robot.report.summary import read_summary
from robot.requests.recorded import ReportRequest


def report_day(request: ReportRequest) -> ExitCode:
    """Summarise the runs of a day, compare them with earlier ones if asked to, and write the page.

    Raises:
        RecordError: A folder holds no logs, or the page cannot be written.
        ConfigError: ``--out`` names no page.
    """
    check_room(request.out, "--out", ".html")
    paths, references = logs_of(request.paths), references_of(request.reference)
    with StatusLine() as line:
        runs = read_runs_of_day(
            paths, lambda at, path: line.say(f"run {at + 1} of {len(paths)}: {path}")
        )
    with ProgressBar("diagnosis") as bar:
        gap = gap_of_day(runs, references, request.jobs, bar.tell)
    read = [one for one in runs if one.summary is not None]
    if request.json:
        print_json(_as_json(runs, gap))
    else:
        print(*day_lines(runs, gap, terminal_width()), sep="\n", flush=True)
    if not read:  # a page without a run would look like one of a day on which nothing moved
        return ExitCode.VERDICT_FAILED
    if not request.json or request.out is not None:
        out = request.out or _page_beside(request.paths[0])
        _write(out, runs, gap, request)
        print(f"page: {out}", file=sys.stderr if request.json else sys.stdout)
    return ExitCode.OK


def _page_beside(first: Path) -> Path:
    """The page's place: in the folder of the runs."""
    return (first if first.is_dir() else first.parent) / "report.html"


def _as_json(runs: tuple[DayRun, ...], gap: DayGap) -> dict[str, object]:
    return {
        "sentence": day_sentence(runs),
        "runs": [
            {"path": one.path, "begun": one.begun, "reason": one.reason or None,
             "odometry_end_percent": one.end_error, "summary": one.summary}
            for one in runs
        ],
        "gap": {"verdict": gap.verdict or None, "words": gap.words, "compared": gap.trials,
                "references": gap.references,
                "not_compared": [{"path": path, "reason": why} for path, why in gap.left_out]},
    }  # fmt: skip


def _write(out: Path, runs: tuple[DayRun, ...], gap: DayGap, request: ReportRequest) -> None:
    """Write the page, that of the diagnosis, and with --pages those of the runs that have none."""
    from robot.day.page import day_page  # and with it what draws pages
    from robot.report.walk_page import walk_page

    pages = {}
    for one in runs:
        page = one.path.with_suffix(".html")
        if one.summary is not None and request.pages and not page.is_file():
            summary, log = read_summary(one.path)
            write_text(page, walk_page(summary, log, str(one.path)))
        if page.is_file():
            pages[one.path] = page
    if gap.diagnosis is not None:
        pages[out] = out.with_name(f"{out.stem}-gap.html")
        write_text(pages[out], gap.page())
    folders = ", ".join(map(str, request.paths[:3])) + (
        " and more" if len(request.paths) > 3 else ""
    )
    write_text(out, day_page(f"Runs in {folders}", runs, gap, out, pages))
