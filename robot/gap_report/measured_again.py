"""What may be applied of a diagnosis, and the gap measured again through the corrected file, in words."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.how_far import HowFar
from gap.diagnosis.remeasured import remeasure
from gap.interfaces import Simulator
from model.errors import GapError
from robot.console.exit_codes import ExitCode
from robot.console.progress import ProgressBar
from robot.gap_report.answer import ReadDiagnosis
from robot.gap_report.study import study_of
from robot.gap_report.trials import Runs
from robot.gap_report.words import changed_channels, rms_words
from robot.requests.gap import MUJOCO

MOST_CHANNELS = 8
SHARE_ROUNDING = 0.02  # of the gap: numbers in a file are rounded
RMS_ROUNDING = 0.005  # of the RMS


def check_applicable(diagnosis: ReadDiagnosis, *, anyway: bool) -> None:
    """Refuse a diagnosis that has nothing to apply, or nothing that should be.

    Raises:
        GapError: It is such a one.
    """
    path, why = diagnosis.path, ""
    if not diagnosis.causes:
        why = f"names no cause (verdict {diagnosis.verdict}): there is nothing to apply"
    elif diagnosis.ill_data and not anyway:
        why = (
            f"is of data with severe faults ({', '.join(diagnosis.ill_data)}): fix the data and diagnose "
            "again, or add --anyway"
        )
    elif diagnosis.on_bound and not anyway:
        why = (
            f"says that {', '.join(diagnosis.on_bound)} is on its bound, so it is no effect of this form; "
            "look for another cause, or add --anyway"
        )
    elif diagnosis.verdict == Verdict.UNEXPLAINED.value and not anyway:
        why = "says that its causes do not explain the gap; apply them all the same with --anyway"
    if why:
        raise GapError(f"{path} {why}")


def measure_again(
    runs: Runs, before: Simulator, after: Simulator, diagnosis: ReadDiagnosis
) -> HowFar:
    """Measure the gap on the held-out runs of a diagnosis, with both simulators.

    The study is that of the diagnosis: its held-out runs, and its baseline model errors as its answer says
    them. To find these again would cost seconds, and find others with another version of the program or
    another robot file. They are of the robot before it changed and stay beside what the corrected file
    holds. An answer that does not say them, such as of an earlier version, leaves them to be found again.

    Raises:
        GapError: A run cannot be compared.
    """
    with ProgressBar("measuring again") as bar:
        study = study_of(runs, before, diagnosis.standing, own=diagnosis.simulator == MUJOCO)
        return remeasure(study, after, diagnosis.seed, bar.show)


def measured_lines(
    out: Path, diagnosis: ReadDiagnosis, far: HowFar | None, left: Sequence[str] = ()
) -> list[str]:
    """Say what the runs leave open, and how much smaller the gap is; None where it was not measured.

    ``left`` are effects of the diagnosis that the file does not hold.
    """
    lines = []
    if diagnosis.verdict == Verdict.AMBIGUOUS.value:
        others = ", ".join(dict.fromkeys(other for _, other, _ in diagnosis.rivals))
        lines.append(f"note: these runs also allow {others} instead; see bigant gap next")
    if far is None:
        return [*lines, "not measured again: the runs of the diagnosis were moved or deleted"]
    lines += ["", f"measured again through {out.name}, on the held-out runs of the diagnosis:"]
    change = f"{rms_words(far.before)} -> {rms_words(far.after)}"
    lines.append(f"  RMS over all channels {change} of the baseline")
    lines += [f"  {far.fed_words}"] if far.fed_words else []
    if math.isnan(far.after):
        lines.append("  the simulation with this file breaks down")
    elif math.isnan(far.shrink):
        lines.append("  on these runs the gap is too small to measure how much is explained")
    else:
        was = "" if math.isnan(diagnosis.shrink) else f" (diagnosis: {diagnosis.shrink:.0%})"
        lines.append(f"  {_share(far.shrink, (far.low, far.high))} of the gap is explained{was}")
    lines += changed_channels(far, MOST_CHANNELS)
    other = _otherwise(diagnosis, far)
    if not far.after < far.before:
        same = ", as the diagnosis says" if diagnosis.shrink < 0.0 and not other else ""
        lines.append(f"NOT SMALLER{same}: do not use this file; diagnose again with more runs")
    if other:
        lines += _otherwise_lines(diagnosis, far, other, left)
    return lines


def measured_json(
    diagnosis: ReadDiagnosis, far: HowFar | None, left: Sequence[str] = ()
) -> Mapping[str, object] | None:
    """Return what ``--json`` says of it."""
    if far is None:
        return None
    return {
        "before": far.before,
        "after": far.after,
        "end_to_end": far.end_to_end,
        "shrink": far.shrink,
        "shrink_interval": [far.low, far.high],
        "shrink_in_diagnosis": diagnosis.shrink,
        "as_in_diagnosis": not _otherwise(diagnosis, far),
        "passed": exit_code(diagnosis, far, left) is ExitCode.OK,
        "channels": far.channels,
    }


def exit_code(diagnosis: ReadDiagnosis, far: HowFar | None, left: Sequence[str] = ()) -> ExitCode:
    """Whether the gap shrank, and by what the diagnosis says, or was not measured.

    A file that cannot hold all causes, but ``left`` some, may close another share.
    """
    if far is None:
        return ExitCode.OK
    fine = far.after < far.before and (bool(left) or not _otherwise(diagnosis, far))
    return ExitCode.OK if fine else ExitCode.VERDICT_FAILED


def _otherwise(diagnosis: ReadDiagnosis, far: HowFar) -> str:
    """How the measured share differs from that of the diagnosis; empty where it does not, or is not known.

    The same runs and causes give the same share, so that what is outside its interval is no chance.
    """
    before, again, (low, high) = diagnosis.shrink, far.shrink, diagnosis.interval
    if math.isnan(before) or math.isnan(far.after):
        return ""
    if math.isnan(again):
        return "there is hardly a gap"
    if min(abs(before), abs(again)) > SHARE_ROUNDING and (before > 0) != (again > 0):
        return "the share has the other sign"
    if again < low - SHARE_ROUNDING or again > high + SHARE_ROUNDING:
        return "the share is outside its interval"
    return ""


def _otherwise_lines(
    diagnosis: ReadDiagnosis, far: HowFar, other: str, left: Sequence[str]
) -> list[str]:
    share = _share(diagnosis.shrink, diagnosis.interval)
    if left:
        return [
            f"note: the diagnosis measured {share}, with what is not written ({', '.join(left)})"
        ]
    lines = [f"NOT AS IN THE DIAGNOSIS, which measured {share} on these runs: {other}"]
    if abs(far.before - diagnosis.before) > RMS_ROUNDING * diagnosis.before:
        lines += [
            f"  before the correction the RMS is {rms_words(far.before)}, in the diagnosis "
            f"{rms_words(diagnosis.before)}:",
            "  the runs, the robot file, the effects or the version of the program are others",
        ]
    return [*lines, "  do not use this file before you have diagnosed again"]


def _share(value: float, interval: tuple[float, float]) -> str:
    """A share in percent, with its interval if that is known."""
    low, high = interval
    return f"{value:.0%}" + ("" if math.isnan(low) else f" [{low:.0%}, {high:.0%}]")
