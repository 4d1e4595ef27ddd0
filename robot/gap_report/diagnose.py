"""``bigant gap diagnose``: where a simulator differs from measured runs, why, how far it shrinks."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from warnings import catch_warnings, simplefilter

from gap.coverage.blind_spots import blind_spots
from gap.delegate import many_of
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.diagnose import Progress, Proposer, diagnose_study, silent
from gap.interfaces import Simulator
from gap.residuals.cluster import ClusterPredictions, Installation
from gap.residuals.pool import prediction_pool
from gap.residuals.predictions import PredictsElsewhere
from model.errors import ConfigError, GapError
from record.trial.header import LEGGED
from record.trial.trial import Trial
from record.whole_file import check_room, write_text
from robot.console.cluster import cluster_client
from robot.console.exit_codes import ExitCode
from robot.console.json_output import check_json, give_json, to_stdout
from robot.console.program_output import tell
from robot.console.progress import ProgressBar
from robot.console.screen_fit import terminal_width, wrapped
from robot.gap_report.alone import fit_alone
from robot.gap_report.blind import blind_json, blind_lines, check_comparable
from robot.gap_report.legged import proposer_of
from robot.gap_report.split import split_lines, with_hold_out
from robot.gap_report.study import study_of
from robot.gap_report.summary import summary_lines
from robot.gap_report.trials import Runs, read_runs
from robot.gap_report.words import machine_words
from robot.requests.gap import MUJOCO, GapDiagnoseRequest


def diagnose_runs(request: GapDiagnoseRequest) -> ExitCode:
    """Diagnose, print and write what was asked for.

    Raises:
        RecordError: A trial cannot be read, or a report cannot be written.
        GapError: The trials cannot be compared with a simulator.
        ConfigError: ``--html`` names no page, or ``--json`` a file that is no JSON.
    """
    check_json(request.json)
    check_room(request.html, "--html", ".html")
    if request.dask is not None and (request.alone or request.sim == MUJOCO):
        words = (
            "spreads the search of a diagnosis; it goes neither with --alone nor with --sim mujoco"
        )
        raise ConfigError("--dask", words)
    if request.alone:
        return fit_alone(request)
    if request.effect:
        raise ConfigError("--effect", "goes with --alone; --effects-only limits --sim mujoco")
    diagnosis = report_diagnosis(request)
    bad = diagnosis.verdict is Verdict.UNEXPLAINED or diagnosis.severe_channels
    return ExitCode.VERDICT_FAILED if bad else ExitCode.OK


def report_diagnosis(request: GapDiagnoseRequest) -> Diagnosis:
    """Diagnose, print and write what was asked for, and return what was found.

    Raises:
        RecordError: A trial cannot be read, or a report cannot be written.
        GapError: The trials cannot be compared with a simulator.
    """
    runs = read_runs(
        request.trials, request.reference, request.robot, request.joint, request.machine
    )
    runs = with_hold_out(runs, request.trials, request.hold_out)
    simulator = simulator_of(runs, request)
    if not to_stdout(request.json):
        for line in split_lines(runs, simulator, request.trials, request.hold_out):
            tell("\n".join(wrapped(line, terminal_width())))
    # what cannot be seen is a matter of sensors and runs: the chain says it for MuJoCo as well
    chain = runs.simulator(request.effects) if request.sim == MUJOCO else simulator
    spots = blind_spots(chain, runs.trials)
    check_comparable(spots, runs.trials)
    if not to_stdout(request.json):
        for line in blind_lines(spots):
            tell("\n".join(wrapped(line, terminal_width())))
        tell("")
    notes: list[str] = []
    with ProgressBar("diagnosis") as bar:
        diagnosis = diagnosis_of(runs, simulator, request, bar.tell, notes.append)
    if notes and not to_stdout(request.json):
        tell("\n".join(wrapped("; ".join(notes), terminal_width())) + "\n")
    paths = (*request.trials, *request.reference)
    result = {**diagnosis_result(diagnosis, paths, runs), "before_judging": blind_json(spots)}
    if not to_stdout(request.json):  # first, so that it is not lost if a file cannot be written
        tell("\n".join(summary_lines(diagnosis, paths, terminal_width(), request.json)))
    give_json(result, request.json)
    if request.html is not None:
        from robot.gap_report.page import diagnosis_page  # and with it matplotlib

        today = datetime.now(tz=UTC).astimezone().date()
        machine = machine_words(runs.trials[0])
        unseen = blind_lines(spots)
        page = diagnosis_page(diagnosis, machine, today, request.trials, request.reference, unseen)
        write_text(request.html, page, "--html")
        if not to_stdout(request.json):
            tell(f"page: {request.html}")
    return diagnosis


def diagnosis_result(d: Diagnosis, paths: Sequence[Path], runs: Runs) -> dict[str, object]:
    """Return what ``--json`` writes: a diagnosis, and the files that it is of."""
    return {
        **diagnosis_json(d),
        "files": paths,
        "references": len(runs.references),
        "robot": runs.robot,
        "machine": runs.machine,
        "joints": runs.joints,
    }


def diagnosis_of(
    runs: Runs,
    simulator: Simulator,
    request: GapDiagnoseRequest,
    progress: Progress = silent,
    notice: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Diagnose runs that are read; files and reports that the request names are not looked at.

    Args:
        runs: Trials and references.
        simulator: Of ``simulator_of``.
        request: How many processes, and which seed.
        progress: Gets what is being done, and the share of the whole that is done.
        notice: Gets what a reader should know besides the diagnosis.

    Raises:
        GapError: The trials cannot be compared with the simulator.
    """
    with _elsewhere(runs, simulator, request) as executor:
        progress("baseline model errors", 0.02)
        own = request.sim == MUJOCO or request.effects is not None  # more than runs and program
        study = study_of(
            runs, simulator, None, executor, own=own, fresh=request.fresh, notice=notice
        )
        return diagnose_study(study, progress, request.seed, _proposer(runs, simulator))


@contextmanager
def _elsewhere(
    runs: Runs, simulator: Simulator, request: GapDiagnoseRequest
) -> Iterator[PredictsElsewhere | None]:
    """Yield where predictions are made: processes of this machine, a cluster, or None for this process."""
    if request.dask is not None:
        with cluster_client(request.dask) as client, client.get_executor() as executor:
            with catch_warnings():
                simplefilter("ignore")  # that runs are large: they are sent once
                # a task, not scattered data: made again where the worker that had it is lost
                made = partial(_installed, runs, request)
                installed = client.submit(Installation, made, pure=False)
            yield ClusterPredictions(
                executor, installed, lambda: len(client.scheduler_info(-1)["workers"])
            )
    elif request.jobs == 1 or many_of(simulator) is not None:
        yield None  # or it has threads of its own
    else:
        with prediction_pool(simulator, runs.trials, runs.references, request.jobs) as pool:
            yield pool


def _installed(runs: Runs, request: GapDiagnoseRequest) -> tuple[Simulator, tuple[Trial, ...]]:
    """Make, on a worker, what this process has."""
    return simulator_of(runs, request), (*runs.trials, *runs.references)


def simulator_of(runs: Runs, request: GapDiagnoseRequest) -> Simulator:
    """Return the simulator that a request asks for, of the machine of the runs.

    Raises:
        GapError: Their machine has none, or its file or the file of effects cannot be used.
        ConfigError: Options that do not go together.
    """
    if request.sim != MUJOCO:
        if request.effects_only:
            raise ConfigError("--effects-only", "goes with --sim mujoco; the chain tries them all")
        return runs.simulator(request.effects)
    kind = runs.trials[0].header.kind
    if kind != LEGGED:
        raise GapError(f"--sim mujoco is for legged robots; the trials are of kind {kind}")
    if request.effects is not None:
        words = "are for the chain; --sim mujoco has its own (--effects-only)"
        raise ConfigError("--effects", words)
    from robot.gap_report.mujoco import mujoco_simulator  # and with it MuJoCo

    return mujoco_simulator(runs, request.effects_only, request.screen, request.jobs)


def _proposer(runs: Runs, simulator: Simulator) -> Proposer | None:
    """What the robot could run next; only the legged chain is quick enough to try it all."""
    if simulator.name != "legged":
        return None
    try:
        return proposer_of(runs.robot_text, runs.robot)[0].proposals
    except GapError:
        return None  # a robot of other legs without gaits: it can be diagnosed, not sent walking
