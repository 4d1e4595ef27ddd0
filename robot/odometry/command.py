"""``bigant odom LOG``: the estimator over a log, judged against the truth if there is one."""

import sys
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.values.estimate import Health
from record.log.blocks.read import read_log
from record.log.reader import LogContents
from record.log.recording import Recording
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.program_output import complain
from robot.console.progress import ProgressLine
from robot.console.screen_fit import columns_of
from robot.control.effect_uses import unused_notes
from robot.odometry.compare import (
    OWN_TRUTH,
    OdometryComparison,
    compare_methods,
    judged_part,
    stride_of,
    walking_part,
)
from robot.odometry.health import LOST_SHARE
from robot.odometry.request import check
from robot.odometry.stretches import track_stretches
from robot.odometry.table import as_json, table
from robot.odometry.track import track_log
from robot.report.walk_frames import fit_contact, walk_frames
from robot.requests.recorded import OdomRequest


def odom(request: OdomRequest) -> ExitCode:
    """Run the estimator over a log, show its result, and write it; or follow a run, or tune.

    An estimate that was lost most of the time, and a comparison without a truth to compare with, are bad
    verdicts.

    Raises:
        RecordError: A log cannot be read or used, or a file cannot be written.
        ConfigError: A robot file is none, or options do not fit each other.
    """
    check(request)
    if request.live:
        from robot.odometry.live import run_live  # and with it all that a run needs

        return run_live(request)
    if request.tunes:
        from robot.odometry.tune import tune_command  # and with it SciPy's search

        return tune_command(request)
    path, contents = request.logs[0], LogContents()
    with ProgressLine(f"estimating {path}", contents.progress):
        tracked = track_stretches(path, request, contents)
        if tracked is None:
            contents.progress.begin_again()
            tracked = track_log(path, request, contents)
    log = tracked.log
    check_shafts(log, path)
    if not contents.config_text and request.robot is None:
        complain(
            f"{path} holds no robot file: taken for a BigANT; give its robot file with --robot"
        )
    if contents.damage:
        complain(f"{path} is {contents.damage}; the estimate knows nothing of what is missing")
    for note in unused_notes(tracked.config.effects):
        complain(note)
    fitted, stride_m, stride_from = None, np.nan, OWN_TRUTH
    if request.fitted is not None:
        other = read_log(request.fitted)
        walk = walk_frames(other, request.fitted.name)
        fitted = fit_contact(walk, other.names, free_w=False, rest_m_s=1e-3).contact
        stride_m, stride_from = stride_of(other), f"{request.fitted.name}, as given with --fitted"
    elif request.compare:
        stride_m = stride_of(log)
    comparison = compare_methods(
        tracked, fitted=fitted, stride_m=stride_m, stride_from=stride_from,
        simpler=request.compare or request.json,
    )  # fmt: skip
    shown = comparison if request.compare else comparison.of_estimator()
    if request.json:
        print_json(as_json(comparison))
    else:
        print(*table(shown, columns_of(sys.stdout)), sep="\n")
    for out, option in ((request.out, "--out"), (request.html, "--html")):
        if out is not None:
            from robot.odometry.files import write  # pictures and pages take a second to load

            write(shown, log, path, out, option)
            if not request.json:
                print(f"written: {out}")
    return _verdict(comparison, log, path, compare=request.compare)


def check_shafts(log: Recording, path: Path) -> None:
    """Refuse a walk without what the estimator cannot do without.

    Raises:
        RecordError: No leg has a shaft angle, or none has a speed.
    """
    span = walking_part(log)
    if not np.isfinite(log.angle_rad[span]).any():
        raise RecordError(
            f"{path} has no shaft angles, and odometry needs them; import the table again with a map of "
            f"its shaft_J_rad (J: {', '.join(log.names)})"
        )
    if not np.isfinite(log.rate_rad_s[span]).any():
        raise RecordError(
            f"{path} has shaft angles and no shaft speeds (shaft_J_rad_s); import its table again: "
            "bigant import computes speeds from the angles"
        )


def _verdict(
    comparison: OdometryComparison, log: Recording, path: Path, *, compare: bool
) -> ExitCode:
    """Say what is bad about an answer, and how the command ends."""
    estimates = comparison.track.estimates
    verdicts = zip(estimates.healths, estimates.reasons, strict=True)
    lost = [reason for health, reason in verdicts if health is Health.LOST]
    span = judged_part(log)
    blind = int(np.isnan(log.rate_rad_s[span] + log.angle_rad[span]).all(axis=1).sum())
    verdict = ExitCode.OK
    if max(len(lost), blind) > LOST_SHARE * len(estimates):
        share = 100 * max(len(lost), blind) / len(estimates)
        why = lost[-1] if len(lost) >= blind else "no leg had a shaft angle and a speed"
        complain(f"the estimator was lost in {share:.0f} % of the ticks: {why}")
        verdict = ExitCode.VERDICT_FAILED
    if compare and comparison.truth is None:
        complain(
            f"nothing to compare with: {path} has no ground truth; import them with the run "
            "(body_x_m, body_y_m and an orientation), or leave --compare out"
        )
        verdict = ExitCode.VERDICT_FAILED
    return verdict
