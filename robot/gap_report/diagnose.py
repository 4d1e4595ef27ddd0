"""``bigant gap diagnose``: where a simulator differs from measured runs, why, how far it shrinks."""

from datetime import UTC, datetime

from gap.diagnosis.as_json import diagnosis_json
from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.findings import Diagnosis, Verdict
from gap.interfaces import Simulator
from gap.proposals import Proposer
from gap.residuals.predictions import prediction_pool
from model.errors import ConfigError, GapError
from record.trial.header import LEGGED
from record.whole_file import check_room, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import check_json, give_json, to_stdout
from robot.console.progress import ProgressBar
from robot.console.screen_fit import terminal_width
from robot.gap_report.runs import proposer_of
from robot.gap_report.summary import summary_lines
from robot.gap_report.trials import Runs, read_runs
from robot.gap_report.words import subject_of
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
    runs = read_runs(request.trials, request.reference, request.robot, request.joint)
    found = _diagnosis(runs, _simulator(runs, request), request)
    paths = (*request.trials, *request.reference)
    result = {
        **diagnosis_json(found),
        "files": paths,
        "references": len(request.reference),
        "robot": request.robot,
    }
    try:  # printed first, so that it is not lost if a file cannot be written
        if not to_stdout(request.json):
            print("\n".join(summary_lines(found, paths, terminal_width())), flush=True)
    finally:  # written also if nobody reads what is printed, as with `| head`
        give_json(result, request.json)
    if request.html is not None:
        from robot.gap_report.page import diagnosis_page  # and with it matplotlib

        today = datetime.now(tz=UTC).astimezone().date()
        subject = subject_of(runs.trials[0], request.trials, request.reference, today)
        write_text(request.html, diagnosis_page(found, subject), "--html")
        if not to_stdout(request.json):
            print(f"page: {request.html}")
    return ExitCode.VERDICT_FAILED if found.verdict is Verdict.UNEXPLAINED else ExitCode.OK


def _simulator(runs: Runs, request: GapDiagnoseRequest) -> Simulator:
    if request.sim != MUJOCO:
        if request.effects_only:
            raise ConfigError(
                "--effects-only", f"goes with --sim {MUJOCO}; the chain tries them all"
            )
        return runs.simulator(request.effects)
    kind = runs.trials[0].header.kind
    if kind != LEGGED:
        raise GapError(f"--sim {MUJOCO} is for legged robots; the trials are of kind {kind}")
    if request.effects is not None:
        raise ConfigError(
            "--effects", f"are for the chain; --sim {MUJOCO} has its own (--effects-only)"
        )
    from robot.gap_report.mujoco import mujoco_simulator  # and with it MuJoCo

    return mujoco_simulator(
        runs.trials,
        runs.references,
        runs.robot_text,
        request.effects_only,
        request.screen,
        request.jobs,
    )


def _diagnosis(runs: Runs, simulator: Simulator, request: GapDiagnoseRequest) -> Diagnosis:
    trials, references, proposer = runs.trials, runs.references, _proposer(runs, simulator)
    with ProgressBar("diagnosis") as bar:
        if request.jobs == 1:
            return diagnose(
                trials, simulator, references, progress=bar.tell, seed=request.seed,
                proposer=proposer,
            )  # fmt: skip
        with prediction_pool(simulator, trials, references, request.jobs) as pool:
            return diagnose(
                trials, simulator, references, executor=pool, progress=bar.tell,
                seed=request.seed, proposer=proposer,
            )  # fmt: skip


def _proposer(runs: Runs, simulator: Simulator) -> Proposer | None:
    """What the robot could run next; only the legged chain is quick enough to try it all."""
    if simulator.name != "legged":
        return None
    try:
        return proposer_of(runs.robot_text, runs.robot)[0]
    except GapError:
        return None  # a robot of other legs without gaits: it can be diagnosed, not sent walking
