"""``bigant odom LOG``: the estimator over a log, judged against the truth if there is one."""

import sys

import numpy as np

from record.log.reader import LogContents, read_log
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.program_output import complain
from robot.console.progress import ProgressLine
from robot.console.screen_fit import columns_of
from robot.control.effect_uses import unused_notes
from robot.odometry.compare import compare_methods, stride_of
from robot.odometry.live import run_live
from robot.odometry.request import check
from robot.odometry.table import as_json, table
from robot.odometry.track import track_log
from robot.odometry.tune import tune_command
from robot.report.walk_frames import fit_contact, walk_frames
from robot.requests.single import OdomRequest


def odom(request: OdomRequest) -> ExitCode:
    """Run the estimator over a log, show its result, and write it; or follow a run, or tune.

    Raises:
        RecordError: A log cannot be read or used, or a file cannot be written.
        ConfigError: A robot file is none, or options do not fit each other.
    """
    check(request)
    if request.live:
        return run_live(request)
    if request.tunes:
        return tune_command(request)
    path, contents = request.logs[0], LogContents()
    with ProgressLine(f"estimating {path}", contents.progress):
        tracked = track_log(path, request, contents)
    log = tracked.log
    for note in unused_notes(tracked.config.effects):
        complain(note)
    fitted, stride_m, source = None, np.nan, ""
    if request.fitted is not None:
        other = read_log(request.fitted)
        walk = walk_frames(other, request.fitted.name)
        fitted = fit_contact(walk, other.names, free_w=False, rest_m_s=1e-3).contact
        stride_m, source = stride_of(other), "fitted log"
    elif request.compare and log.has_truth:
        stride_m, source = stride_of(log), "this log's own truth, so it ends well by itself"
    comparison = compare_methods(tracked, fitted=fitted, stride_m=stride_m)
    shown = comparison if request.compare else comparison.of_estimator()
    if request.json:
        print_json(as_json(comparison))
    else:
        print(*table(shown, columns_of(sys.stdout)), sep="\n")
        if source:
            print(f"distance a stride: {1e3 * stride_m:.1f} mm a cycle, from {source}")
    if request.out is not None:
        from robot.odometry.files import write  # pictures and pages take a second to load

        write(shown, log, path, request.out)
        if not request.json:
            print(f"written: {request.out}")
    return ExitCode.OK
