"""``bigant show``: what a log says, as a table and as pictures."""

import sys

from record.whole_file import check_room, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.screen_fit import columns_of
from robot.console.table import row_lines
from robot.report.pictures import save_pictures
from robot.report.plots import draw_log
from robot.report.summary import read_summary
from robot.report.summary_text import summary_rows
from robot.report.walk_page import walk_page
from robot.requests.recorded import ShowRequest


def show_log(request: ShowRequest) -> ExitCode:
    """Summarise a log and draw it.

    Raises:
        RecordError: The log cannot be read, or the page cannot be written.
        ConfigError: ``--out`` names no kind of file we write.
    """
    # only where it was asked for: the table is shown where no page can be written, too
    check_room(request.out, "--out", ".html", ".png")
    summary, log = read_summary(request.path)
    if request.json:
        print_json(summary)
        return ExitCode.OK
    rows = summary_rows(summary)
    print(*row_lines(rows, columns_of(sys.stdout)), sep="\n")
    out = request.out or request.path.with_suffix(".html")
    if out.suffix == ".png":
        print("pictures: " + ", ".join(map(str, save_pictures(out, draw_log(log)))))
    else:
        write_text(out, walk_page(summary, log, str(request.path)))
        print(f"pictures: {out}")
    return ExitCode.OK
