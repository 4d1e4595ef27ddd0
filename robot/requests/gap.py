"""Requests of ``bigant gap``: where a simulator differs from measured runs, and why."""

import os
from pathlib import Path

from robot.console.arguments import (
    argument,
    as_json,
    between,
    flag,
    json_file,
    names,
    needed,
    option,
    random_seed,
    request,
    several,
)

CHAIN, MUJOCO = "chain", "mujoco"
ONLY_JOINT = "only this joint of a bench of servos; may be given again"
OWN_EFFECTS = "effects of your own (run as Python: open only files that you trust)"
MACHINE = (
    "machine of your own, FILE.py:make (run as Python: open only files that you trust), or an MJCF or URDF "
    "(default: the machine's file that the trials name)"
)
HOLD_OUT = (
    "judge by the runs with this condition, such as trajectory=lift; trial=NAME is one run, last-third the "
    "end of each; may be given again (default: runs spread evenly)"
)
CORES = min(os.cpu_count() or 1, 4)


@request("campaign.check:check_campaign", writes=True)
class GapCheckRequest:
    """``bigant gap check``: diagnose a campaign whose causes are withheld, then open the seal and count.

    Each case is diagnosed with the campaign's healthy runs and its answer kept in --out, before any label
    is looked at; cases answered already are not asked again. Then the labels are opened (labels.json, or
    the sealed ones with --key), and every figure of the protocol is printed with its bar, and the
    confusions. With --removed N, the first N single-effect cases are diagnosed once more with their true
    effect taken out of the catalogue. How visible each effect is, and what its true values would close,
    are measured: against the campaign's controls, or with --scenario against walks of the twin without
    the effects. With --realities CAMPAIGN is a folder with one campaign each (bigant sim campaign
    --reality all): a row of figures a reality, the worst named, and the constants of the probabilities
    fitted on all but one and judged on that one. Exit code 1: some bar is not met.
    """

    campaign: Path = argument("CAMPAIGN", "folder of bigant sim campaign")
    key: Path | None = option("key of the sealed labels", "FILE")
    scenario: Path | None = option(
        "its scenario file: the twin walks each case again to measure what is visible", "FILE"
    )
    out: Path | None = option("where answers are kept (default: CAMPAIGN/answers)", "DIR")
    removed: int = option(
        "single-effect cases to diagnose again without their effect in the catalogue",
        "N",
        default=0,
    )
    no_references: bool = flag("do without the healthy runs")
    realities: bool = flag("CAMPAIGN holds one campaign a reality: judge each for itself")
    dask: str | None = option(
        "scheduler of a Dask cluster that sees CAMPAIGN as well", "tcp://HOST:PORT"
    )
    jobs: int = option("cases at a time (default: one a core, up to 4)", "N", default=CORES)
    json: Path | None = json_file("figures and cases")
    markdown: Path | None = option("figures as tables for a page", "FILE")


@request("gap_report.diagnose:diagnose_runs", writes=True)
class GapDiagnoseRequest:
    """``bigant gap diagnose``: where a simulator differs from measured runs, why, how far it shrinks.

    Takes trial tables (.parquet or .csv with NAME.toml beside it) or logs. The machine's file that they
    name picks the simulator. With --reference, runs of the same machine believed healthy, the question is
    what is new; without, the simulator as it stands is compared with the runs. Some runs are held out and
    judge. Exit code 0: a verdict was reached; 1: there is a gap that no effect of the catalogue explains.
    """

    trials: tuple[Path, ...] = argument("TRIAL", nargs="+")
    reference: tuple[Path, ...] = option(
        "healthy runs of the same machine; what they show is no news",
        "TRIAL",
        nargs="+",
        default=(),
    )
    joint: tuple[str, ...] = several(ONLY_JOINT, "NAME")
    robot: Path | None = option(
        "robot file to use for the trials (default: the one beside them)", "FILE"
    )
    machine: str = option(MACHINE, "FILE", default="")
    hold_out: tuple[str, ...] = several(HOLD_OUT, "KEY=VALUE")
    json: Path | None = json_file("the diagnosis")
    html: Path | None = option("the diagnosis as one page", "FILE")
    effects: Path | None = option(OWN_EFFECTS, "FILE.py")
    sim: str = option(
        "the chain of the model, or the MuJoCo robot (minutes)",
        choices=(CHAIN, MUJOCO),
        default=CHAIN,
    )
    effects_only: tuple[str, ...] = option(
        "with --sim mujoco: effects to try (default: screened by the chain)",
        "A,B",
        default=(),
        type=names,
    )
    screen: int = option(
        "with --sim mujoco: how many effects the chain lets through (default: 4)",
        "N",
        default=4,
        type=between(1, whole=True),
    )
    jobs: int = option(
        "processes (default: one a core, up to 4)", "N", default=CORES, type=between(1, whole=True)
    )
    seed: int = random_seed("seed of random draws")


@request("gap_report.alone:fit_alone")
class GapAloneRequest:
    """``bigant gap alone``: how much of the gap an effect explains by itself, for example a delay.

    Fits effects of the catalogue by least squares to the runs that the diagnosis would fit to, each by
    itself (or several joined with +), and judges them on the held-out runs. It does not say what the cause
    is: it shows what a decoy could have claimed, next to what ``bigant gap diagnose`` names.
    """

    trials: tuple[Path, ...] = argument("TRIAL", nargs="+")
    effect: tuple[str, ...] = several(
        "an effect, or several together; may be given again (default: every effect)",
        "NAME[+NAME...]",
    )
    joint: tuple[str, ...] = several(ONLY_JOINT, "NAME")
    machine: str = option(MACHINE, "FILE", default="")
    hold_out: tuple[str, ...] = several(HOLD_OUT, "KEY=VALUE")
    json: bool = as_json()


@request("gap_report.apply:apply_diagnosis")
class GapApplyRequest:
    """``bigant gap apply``: a diagnosis into a corrected machine's file, and the gap measured again.

    Causes that have a key of their own (links, mounts, springs, friction) change that key; all others go
    into a table [effects], which drive, odom, sim, replay and gap read. All comments stay. Then the
    corrected file is read back, and the held-out runs of the diagnosis are predicted with it: before and
    after are printed. Other machines write causes into their own file in their own way (a bench of servos
    in [joint.NAME.effects]), or say why not. Exit code 1: the gap did not shrink.
    """

    diagnosis: Path = argument("DIAGNOSIS.json")
    robot: Path | None = option(
        "robot file to correct (default: the one that the runs name)", "FILE"
    )
    out: Path = needed("the corrected file; a folder where the runs name several", "FILE|FOLDER")
    anyway: bool = flag("apply the causes of a diagnosis that does not explain the gap, too")
    json: bool = as_json("what was done as JSON")


@request("gap_report.next:propose_runs")
class GapNextRequest:
    """``bigant gap next``: which run settles what a diagnosis left open.

    Takes the JSON of a diagnosis (its runs must still be where they were), or runs, which are diagnosed
    first. Each gait at several frequencies, straight and turning, and with a weight on the body, is played
    through the simulator with each candidate; what is left of their difference after one is adjusted to the
    other, in units of the noise, is the separation that the run would show. A separation of 22 decides with
    one error in a hundred. Machines other than legged robots propose their own runs, or say what to vary.
    """

    paths: tuple[Path, ...] = argument("DIAGNOSIS.json|TRIAL", nargs="+")
    reference: tuple[Path, ...] = option(
        "with TRIAL: healthy runs of the same machine", "TRIAL", nargs="+", default=()
    )
    against: tuple[str, ...] = several(
        "a candidate in place of the first cause, besides those left open", "EFFECT[@LEG]"
    )
    robot: Path | None = option("robot file to use (default: the one that the runs name)", "FILE")
    gait: str | None = option("propose runs with the gait of a Python file as well", "FILE.py")
    effects: Path | None = option(OWN_EFFECTS, "FILE.py")
    all: bool = flag("show all runs, not only 5")
    json: bool = as_json("all runs as JSON")


@request("gap_report.effects:list_effects")
class GapEffectsRequest:
    """``bigant gap effects``: the catalogue of what a simulator may lack.

    Each effect with its stage, what it can touch, its numbers with units and bounds, its physics and what a
    person would do about it. With --effects FILE.py a user's own effects are listed behind them, which also
    checks the file (it is run as Python: open only files that you trust).
    """

    effects: Path | None = option("effects of your own", "FILE.py")
    stage: str | None = option("only those of one stage", "STAGE")
    json: bool = as_json("print JSON")
