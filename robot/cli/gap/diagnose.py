"""``bigant gap diagnose``: where a simulator differs from measured runs, why, how far it shrinks.

Takes trial tables (.parquet or .csv with NAME.toml beside it) or logs. The machine's file that they name
picks the simulator. With --reference, runs of the same machine believed healthy, the question is what is
new; without, the simulator as it stands is held against the runs. Some runs are kept back and judge. Exit
code 0: a verdict was reached; 1: there is a gap that no effect of the catalogue explains.
"""

import argparse
import os
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.arguments import seed
from robot.console.exit_codes import ExitCode
from robot.console.json_output import add_json, check_json, give_json, to_stdout

CHAIN, MUJOCO = "chain", "mujoco"

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gap.diagnosis.findings import Diagnosis
    from gap.interfaces import Simulator
    from gap.proposals import Proposer
    from record.trial.trial import Trial


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("trials", type=Path, nargs="+", metavar="TRIAL")
    parser.add_argument("--reference", type=Path, nargs="+", default=[], metavar="TRIAL",
        help="healthy runs of the same machine; what they show is no news")  # fmt: skip
    parser.add_argument("--joint", action="append", default=[], metavar="NAME",
        help="only this joint of a bench of servos; may be given again")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to believe of the trials (default: the one beside them)")  # fmt: skip
    add_json(parser, "the diagnosis")
    parser.add_argument("--html", type=Path, metavar="FILE", help="the diagnosis as one page")
    parser.add_argument("--effects", type=Path, metavar="FILE.py",
        help="effects of your own (run as Python: open only files that you trust)")  # fmt: skip
    parser.add_argument("--sim", choices=(CHAIN, MUJOCO), default=CHAIN,
        help="the chain of the model, or the MuJoCo robot (minutes)")  # fmt: skip
    parser.add_argument("--effects-only", type=_names, default=(), metavar="A,B",
        help="with --sim mujoco: effects to try (default: screened by the chain)")  # fmt: skip
    parser.add_argument("--screen", type=_jobs, default=4, metavar="N",
        help="with --sim mujoco: how many effects the chain lets through (default: 4)")  # fmt: skip
    parser.add_argument("--jobs", type=_jobs, default=min(os.cpu_count() or 1, 4), metavar="N",
        help="processes (default: one a core, up to 4)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of random draws")


def _names(text: str) -> tuple[str, ...]:
    return tuple(name for part in text.split(",") if (name := part.strip()))


def _jobs(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Diagnose.

    Raises:
        RecordError: A trial cannot be read, or a report cannot be written.
        GapError: The trials cannot be compared with a simulator.
        ConfigError: ``--html`` names no page, or ``--json`` a file that is no JSON.
    """
    from gap.diagnosis.findings import Verdict
    from model.errors import ConfigError
    from record.whole_file import check_room
    from robot.console.lines import terminal_width
    from robot.gap_report.summary import summary_lines
    from robot.gap_report.trials import read_trials, simulator_for
    from robot.report.page import write_page

    check_json(options.json)
    check_room(None if to_stdout(options.json) else options.json, "--json")
    check_room(options.html, "--html")
    if options.html is not None and options.html.suffix != ".html":
        raise ConfigError("--html", f"must end in .html, not {options.html.name!r}")
    paths = (*options.trials, *options.reference)
    everything = read_trials(paths, tuple(options.joint))
    trials = everything[: len(options.trials)]
    references = everything[len(options.trials) :]
    if options.sim == MUJOCO:
        simulator = _mujoco(trials, references, options)
    else:
        if options.effects_only:
            raise ConfigError(
                "--effects-only", f"goes with --sim {MUJOCO}; the chain tries them all"
            )
        simulator = simulator_for(everything, options.effects, options.robot, references)
    found = _diagnose(trials, references, simulator, options)
    if not to_stdout(options.json):  # first, so that it is not lost if a file cannot be written
        print("\n".join(summary_lines(found, paths, terminal_width())), flush=True)
    if options.json is not None:
        from gap.diagnosis.as_json import diagnosis_json

        told = {
            **diagnosis_json(found),
            "files": [str(path) for path in paths],
            "references": len(references),
            "robot": None if options.robot is None else str(options.robot),
        }
        give_json(told, options.json, indent=2)
    if options.html is not None:
        from robot.gap_report.page import diagnosis_page
        from robot.gap_report.subject import subject_of

        today = datetime.now(tz=UTC).astimezone().date()
        subject = subject_of(trials[0], options.trials, options.reference, today)
        write_page(options.html, diagnosis_page(found, subject))
    if not to_stdout(options.json) and options.html is not None:
        print(f"page: {options.html}")
    return ExitCode.VERDICT_FAILED if found.verdict is Verdict.UNEXPLAINED else ExitCode.OK


def _mujoco(
    trials: "Sequence[Trial]", references: "Sequence[Trial]", options: argparse.Namespace
) -> "Simulator":
    from model.errors import ConfigError, GapError
    from record.trial.header import LEGGED
    from robot.gap_report.mujoco import mujoco_simulator
    from robot.gap_report.trials import robot_text

    header = trials[0].header
    if header.kind != LEGGED:
        raise GapError(f"--sim {MUJOCO} is for legged robots; the trials are of kind {header.kind}")
    if options.effects is not None:
        raise ConfigError(
            "--effects", f"are for the chain; --sim {MUJOCO} has its own (--effects-only)"
        )
    text = header.robot_text if options.robot is None else robot_text(options.robot)
    return mujoco_simulator(
        trials, references, text, options.effects_only, options.screen, options.jobs
    )


def _diagnose(
    trials: "Sequence[Trial]",
    references: "Sequence[Trial]",
    simulator: "Simulator",
    options: argparse.Namespace,
) -> "Diagnosis":
    from gap.diagnosis.diagnose import diagnose
    from gap.residuals.predictions import prediction_pool
    from robot.console.progress import ProgressBar

    proposer = _proposer(trials, simulator, options)
    with ProgressBar("diagnosis") as bar:

        def tell(words: str, share: float) -> None:
            bar.show(share, words)

        if options.jobs == 1:
            return diagnose(
                trials, simulator, references, progress=tell, seed=options.seed, proposer=proposer
            )
        with prediction_pool(simulator, trials, references, options.jobs) as pool:
            return diagnose(
                trials, simulator, references, executor=pool, progress=tell, seed=options.seed,
                proposer=proposer,
            )  # fmt: skip


def _proposer(
    trials: "Sequence[Trial]", simulator: "Simulator", options: argparse.Namespace
) -> "Proposer | None":
    """What the robot could run next; only the legged chain is quick enough to try it all."""
    from model.errors import GapError
    from robot.gap_report.runs import proposer_of
    from robot.gap_report.trials import robot_text

    if simulator.name != "legged":
        return None
    text = trials[0].header.robot_text if options.robot is None else robot_text(options.robot)
    try:
        return proposer_of(text, options.robot)[0]
    except GapError:
        return None  # a robot of other legs without gaits: it can be diagnosed, not sent walking
