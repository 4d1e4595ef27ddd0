"""``bigant gap apply`` for any machine: its kind writes causes into the machine's file, or says why not."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gap.delegate import MachineKey, MachineOfEach, machine_key
from gap.interfaces import Simulator
from gap.machine_kinds import MachineKind
from model.errors import GapError
from record.trial.header import KIND_OF_SUFFIX
from record.trial.trial import Trial
from record.whole_file import check_room, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.gap_report.answer import DiagnosedRuns, read_diagnosis
from robot.gap_report.measured_again import (
    check_applicable,
    exit_code,
    measure_again,
    measured_json,
    measured_lines,
)
from robot.gap_report.trials import Runs, runs_of_diagnosis
from robot.requests.gap import GapApplyRequest


def apply_to_machine(request: GapApplyRequest, of: DiagnosedRuns) -> ExitCode:
    """Correct the machine's file, or each of several, and measure again.

    Raises:
        RecordError: A file cannot be read or written.
        GapError: There is nothing to apply, or the machine's file cannot hold it.
    """
    runs = runs_of_diagnosis(of, request.robot)
    simulator, kind = runs.simulator(), runs.kind
    diagnosis = read_diagnosis(request.diagnosis, simulator.effects)
    if kind.apply is None:
        raise GapError(f"{of.path}: a machine of kind {kind.name} {kind.no_apply}")
    check_applicable(diagnosis, anyway=request.anyway)
    texts = {one.header.robot_file: one.header.robot_text for one in runs.trials}
    if "" in texts:
        raise GapError(
            f"the runs of {of.path} name no machine's file to correct; give it with --robot"
        )
    out = request.out
    if len(texts) > 1 and out.suffix:
        raise GapError(
            f"the runs name {len(texts)} machine's files ({', '.join(texts)}); give --out a folder for them"
        )
    files = {name: out / name if len(texts) > 1 or not out.suffix else out for name in texts}
    for name, file in files.items():
        suffix = Path(name).suffix
        if file.parent.is_dir() or not out.parent.is_dir():  # else the folder will be made
            check_room(file, "--out", ".xml" if suffix in KIND_OF_SUFFIX else suffix)
        if file.exists():
            raise GapError(f"--out: {file} exists; choose another name")
    corrected = {
        name: kind.apply(text, diagnosis.causes, simulator.effects) for name, text in texts.items()
    }
    after = _corrected(kind, runs, corrected)  # read from its text, as every command does
    for name, file in files.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, corrected[name])
    left = kind.left(diagnosis.causes, simulator.effects) if kind.left else ()
    far = measure_again(runs, simulator, after, diagnosis)
    if request.json:
        about = {"files": list(files.values()), "not_written": list(left)}
        print_json({**about, "gap": measured_json(diagnosis, far, left)})
    else:
        lines = [f"written: {file}" for file in files.values()]
        if left:
            lines.append(
                f"not written, as it is of the drive or the log, not of this file: {', '.join(left)}"
            )
        print("\n".join([*lines, *measured_lines(out, diagnosis, far, left)]))
    return exit_code(diagnosis, far, left)


def _corrected(kind: MachineKind, runs: Runs, corrected: dict[str, str]) -> Simulator:
    """The simulator of the corrected files, which answers for the trials as they are."""
    groups: dict[MachineKey, list[Trial]] = {}
    for one in runs.trials:
        groups.setdefault(machine_key(one.header), []).append(one)
    machines = []
    for key, own in groups.items():
        name = own[0].header.robot_file
        machines.append((key, name, kind.make(_with_text(own, corrected[name]))))
    return MachineOfEach(machines)


def _with_text(trials: Sequence[Trial], text: str) -> list[Trial]:
    return [replace(one, header=replace(one.header, robot_text=text)) for one in trials]
