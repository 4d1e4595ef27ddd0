"""``bigant gap apply`` for any kind of machine: its file corrected by its own rules, and measured again."""

import math
from pathlib import Path

from gap.diagnosis.findings import Verdict
from gap.diagnosis.how_far import HowFar
from gap.diagnosis.remeasured import remeasure
from model.errors import GapError
from record.trial.header import KIND_OF_SUFFIX
from record.whole_file import check_room, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar
from robot.gap_report.answer import ReadDiagnosis, read_diagnosis
from robot.gap_report.trials import Runs, read_trials, runs_of
from robot.gap_report.words import changed_channels
from robot.requests.gap import GapApplyRequest

MOST_CHANNELS = 8


def apply_to_machine(request: GapApplyRequest) -> ExitCode:
    """Correct the file of a machine of any kind, and measure again.

    Raises:
        RecordError: A file cannot be read or written.
        GapError: There is nothing to apply, or the machine's file cannot hold it.
    """
    asked = read_diagnosis(request.diagnosis, None)
    if not asked.trials:
        raise GapError(
            f"the runs of {asked.path} are not where they were, and they say what machine it is; put them "
            "back, or diagnose again"
        )
    runs = _runs(asked, request.robot or asked.robot, asked.machine)
    kind, header = runs.kind, runs.trials[0].header
    if kind.apply is None:
        raise GapError(f"a machine of kind {kind.name} {kind.no_apply}")
    if len({one.header.robot_text for one in runs.trials}) > 1:
        raise GapError(
            f"the runs of {asked.path} name several machine's files, and one is written: diagnose the runs "
            "of one file, and apply that"
        )
    suffix = Path(header.robot_file).suffix or ".toml"
    check_room(request.out, "--out", ".xml" if suffix in KIND_OF_SUFFIX else suffix)
    before = runs.simulator()
    diagnosis = read_diagnosis(request.diagnosis, before.effects)
    check_worth(diagnosis, anyway=request.anyway)
    write_text(request.out, kind.apply(header.robot_text, diagnosis.causes, before.effects))
    after = _runs(asked, request.out, "").simulator()
    with ProgressBar("measuring again") as bar:
        far = remeasure(runs.trials, runs.references, before, after, progress=bar.show)
    if request.json:
        print_json({"file": request.out, "gap": gap_json(far)})
    else:
        print("\n".join([f"written: {request.out}", *measured_lines(request.out, diagnosis, far)]))
    return ExitCode.OK if far.after < far.before else ExitCode.VERDICT_FAILED


def _runs(asked: ReadDiagnosis, robot: Path | None, machine: str) -> Runs:
    """The runs of a diagnosis, with the machine's file that it used or another one."""
    everything = read_trials((*asked.trials, *asked.references))
    count = len(asked.trials)
    return runs_of(everything[:count], everything[count:], robot, machine)


def check_worth(diagnosis: ReadDiagnosis, *, anyway: bool) -> None:
    """Refuse a diagnosis whose causes are not to be written into a file.

    Raises:
        GapError: It names none, one on its bound, or they do not explain the gap.
    """
    path, why = diagnosis.path, ""
    if not diagnosis.causes:
        why = f"names no cause (verdict {diagnosis.verdict}): there is nothing to apply"
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
    """Return what a corrected file closes of the gap, for a person; None was not measured."""
    if far is None:
        return ["not measured again: the runs of the diagnosis are not where they were"]
    lines = ["", f"measured again through {out.name}, on the held-out runs of the diagnosis:"]
    lines.append(f"  RMS over all channels {far.before:.3g} -> {far.after:.3g} of the floor")
    if math.isnan(far.shrink):
        lines.append("  on these runs the gap is too small to measure how much is closed")
    else:
        was = "" if math.isnan(diagnosis.shrink) else f" (diagnosis: {diagnosis.shrink:.0%})"
        lines.append(
            f"  {far.shrink:.0%} [{far.low:.0%}, {far.high:.0%}] of the gap is closed{was}"
        )
    lines += changed_channels(far, MOST_CHANNELS)
    if not far.after < far.before:
        lines.append("NOT SMALLER: do not use this file; diagnose again with more runs")
    return lines


def gap_json(far: HowFar | None) -> dict[str, object] | None:
    """Return the same for ``--json``."""
    return None if far is None else {
        "before": far.before,
        "after": far.after,
        "shrink": far.shrink,
        "shrink_interval": [far.low, far.high],
        "channels": far.channels,
    }  # fmt: skip
