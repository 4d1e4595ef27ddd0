"""``bigant show``: what a log says, as a table and as pictures.

Print a summary of a log (distance, speed, slip, faults, loop) and write a page with trajectory, body
velocity and foot forces, predicted against measured.
"""

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from model.errors import ConfigError, RecordError
from record.whole_file import check_room
from robot.console.exit_codes import ExitCode
from robot.console.plain_json import plain
from robot.console.screen_fit import columns_of
from robot.report.long_log import read_summary
from robot.report.summary_text import summary_rows, table_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=".html or .png (default: next to the log, .html)"
    )
    parser.add_argument("--json", action="store_true", help="the summary as JSON, no picture")


def run(options: argparse.Namespace) -> ExitCode:
    """Show a log."""
    return show(options)


def show(options: argparse.Namespace) -> ExitCode:
    """Summarise a log and draw it.

    Raises:
        RecordError: The log cannot be read, or the page cannot be written.
        ConfigError: ``--out`` names no kind of file we write.
    """
    out: Path = options.out if options.out is not None else options.path.with_suffix(".html")
    if out.suffix not in {".html", ".png"}:
        raise ConfigError("--out", f"must end in .html or .png, not {out.suffix or out.name!r}")
    check_room(
        options.out, "--out"
    )  # by default the table is shown where no page can be written, too
    summary, log = read_summary(options.path)
    if options.json:
        print(json.dumps(plain(asdict(summary)), indent=2))
        return ExitCode.OK
    rows = summary_rows(summary)
    for line in table_lines(rows, columns_of(sys.stdout)):
        print(line)
    from robot.report.page import render_page
    from robot.report.plots import draw_log, save_png
    from robot.report.run_date import run_words, software_words

    figures = draw_log(log)
    try:
        if out.suffix == ".png":
            written = save_png(figures, out)
        else:
            note = ", ".join((run_words(options.path, log.metadata), software_words(log.metadata)))
            title = f"{log.metadata.get('robot', 'Robot')}: {summary.gait}"
            out.write_text(render_page(title, note, rows, figures), encoding="utf-8")
            written = (out,)
    except OSError as error:
        raise RecordError(
            f"{out} cannot be written: {error.strerror}; choose another --out"
        ) from error
    print("pictures: " + ", ".join(str(path) for path in written))
    return ExitCode.OK
