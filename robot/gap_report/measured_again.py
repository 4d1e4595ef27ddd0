"""What may be applied of a diagnosis, and the gap measured again through the corrected file, in words."""

import math
from collections.abc import Mapping
from pathlib import Path

from gap.diagnosis.findings import Verdict
from gap.diagnosis.how_far import HowFar
from model.errors import GapError
from robot.console.exit_codes import ExitCode
from robot.gap_report.answer import ReadDiagnosis
from robot.gap_report.words import changed_channels, rms_words

MOST_CHANNELS = 8


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


def measured_lines(out: Path, diagnosis: ReadDiagnosis, far: HowFar | None) -> list[str]:
    """Say what the runs leave open, and how much smaller the gap is; None where it was not measured."""
    lines = []
    if diagnosis.verdict == Verdict.AMBIGUOUS.value:
        others = ", ".join(dict.fromkeys(other for _, other, _ in diagnosis.rivals))
        lines.append(f"note: these runs also allow {others} instead; see bigant gap next")
    if far is None:
        return [*lines, "not measured again: the runs of the diagnosis were moved or deleted"]
    lines += ["", f"measured again through {out.name}, on the held-out runs of the diagnosis:"]
    change = f"{rms_words(far.before)} -> {rms_words(far.after)}"
    lines.append(f"  RMS over all channels {change} of the baseline")
    if math.isnan(far.after):
        lines.append("  the simulation with this file breaks down")
    elif math.isnan(far.shrink):
        lines.append("  on these runs the gap is too small to measure how much is explained")
    else:
        was = "" if math.isnan(diagnosis.shrink) else f" (diagnosis: {diagnosis.shrink:.0%})"
        lines.append(
            f"  {far.shrink:.0%} [{far.low:.0%}, {far.high:.0%}] of the gap is explained{was}"
        )
    lines += changed_channels(far, MOST_CHANNELS)
    if not far.after < far.before:
        lines.append("NOT SMALLER: do not use this file; diagnose again with more runs")
    return lines


def measured_json(far: HowFar | None) -> Mapping[str, object] | None:
    """Return what ``--json`` says of it."""
    if far is None:
        return None
    return {
        "before": far.before,
        "after": far.after,
        "shrink": far.shrink,
        "shrink_interval": [far.low, far.high],
        "channels": far.channels,
    }


def exit_code(far: HowFar | None) -> ExitCode:
    """Whether the gap shrank, or was not measured."""
    closed = far is None or far.after < far.before
    return ExitCode.OK if closed else ExitCode.VERDICT_FAILED
