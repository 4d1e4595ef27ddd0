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
    positive,
    random_seed,
    request,
    robot_file,
    several,
)

CHAIN, MUJOCO = "chain", "mujoco"
ALONE = "one effect at a time"  # heading in the help
ONLY_JOINT = "only this joint of a bench of servos; may be repeated"
OWN_EFFECTS = "effects of your own (run as Python: open only files that you trust)"
MACHINE = (
    "machine of your own, FILE.py:make (run as Python: open only files that you trust), or an MJCF or URDF "
    "(default: the machine's file that the trials name)"
)
HOLD_OUT = (
    "test on the runs with this condition, such as trajectory=lift; trial=NAME is one run, last-third the "
    "end of each; may be repeated (default: runs spread evenly)"
)
WORN_SPRING = "leg_stiffness@MR:ratio=0.69"
CORES = min(os.cpu_count() or 1, 4)


@request("gap_report.demo:run_demo")
class GapDemoRequest:
    """``bigant gap demo``: a first diagnosis, of a fault that is known.

    Makes eight short runs in a new folder: four of a virtual robot with the fault, four of a healthy one.
    Friction, stiffness and centre of mass differ from run to run, as they do from day to day. Diagnoses
    them without knowing the fault, writes the page, and compares the answer with what was injected. Each
    step is a command that is printed, to be repeated with runs of your own. Exit code 1: the answer is not
    what was injected.
    """

    effect: str = option(
        f"what is wrong (default: {WORN_SPRING}; none: nothing; bigant sim effects lists them)",
        "NAME[@LEG][:param=value,...]",
        default=WORN_SPRING,
    )
    robot: Path = robot_file()
    seconds: float = option("of walking a run (default: 30)", "S", default=30.0, type=positive)
    out: Path = option("a new folder (default: runs/demo)", "FOLDER", default=Path("runs/demo"))
    jobs: int = option(
        "processes (default: one a core, up to 4)", "N", default=CORES, type=between(1, whole=True)
    )


@request("gap_report.diagnose:diagnose_runs", writes=True)
class GapDiagnoseRequest:
    """``bigant gap diagnose``: where a simulator differs from measured runs, and why.

    Takes trial tables (.parquet or .csv with NAME.toml next to it) or logs. The machine's file that they
    name selects the simulator. With --reference, healthy runs of the same machine, it finds what is new.
    Without them it compares the runs with the simulator as it is. Some runs are held out for testing. Exit
    code 0: a verdict was reached; 1: there is a gap that no effect of the catalogue explains, or the data
    have a severe fault.

    --alone does not search for the cause. It fits each effect alone and shows how much of the gap that
    effect could explain, for example a delay.
    """

    trials: tuple[Path, ...] = argument("TRIAL", nargs="+")
    reference: tuple[Path, ...] = option(
        "healthy runs of the same machine; their model errors are not reported as new",
        "TRIAL",
        nargs="+",
        default=(),
    )
    joint: tuple[str, ...] = several(ONLY_JOINT, "NAME")
    robot: Path | None = option(
        "robot file to use for the trials (default: the one next to them)", "FILE"
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
    dask: str | None = option(
        "scheduler of a Dask cluster that makes the predictions; its workers have this version installed",
        "tcp://HOST:PORT",
    )
    seed: int = random_seed("seed of random draws")
    fresh: bool = flag(
        "search the references for baseline model errors again; without it those found before for the same "
        "references and version are used"
    )
    alone: bool = flag(
        "do not search: fit each effect alone and judge it on the held-out runs", group=ALONE
    )
    effect: tuple[str, ...] = several(
        "this effect, or several together; may be given again (default: every effect)",
        "NAME[+NAME...]",
        group=ALONE,
    )


@request("gap_report.apply:apply_diagnosis")
class GapApplyRequest:
    """``bigant gap apply``: write a diagnosis into a corrected file, and measure the gap again.

    Causes that have a key of their own (links, mounts, springs, friction) change that key; all others go
    into a table [effects], which drive, odom, sim, replay and gap read. All comments stay. Then the
    held-out runs of the diagnosis are predicted with the corrected file, and the gap before and after is
    printed. Other machines have their own rules (a bench of servos: [joint.NAME.effects]), or say why not.
    Exit code 1: the gap did not shrink, or not by the share that the diagnosis says.
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
    """``bigant gap next``: which run settles an ambiguous diagnosis.

    Takes the JSON of a diagnosis (its runs must still be where they were), or runs, which are diagnosed
    first. Each gait at several frequencies, straight and turning, and with a weight on the body, is
    simulated with each candidate. The separation is their remaining difference after one is fitted to the
    other, in units of the noise. A separation of 22 decides with one error in a hundred. Machines other
    than legged robots propose their own runs, or say what to vary.
    """

    paths: tuple[Path, ...] = argument("DIAGNOSIS.json|TRIAL", nargs="+")
    reference: tuple[Path, ...] = option(
        "with TRIAL: healthy runs of the same machine", "TRIAL", nargs="+", default=()
    )
    against: tuple[str, ...] = several(
        "another candidate to distinguish from the first cause", "EFFECT[@LEG]"
    )
    robot: Path | None = option("robot file to use (default: the one that the runs name)", "FILE")
    gait: str | None = option("propose runs with the gait of a Python file as well", "FILE.py")
    effects: Path | None = option(OWN_EFFECTS, "FILE.py")
    all: bool = flag("show all runs, not only 5")
    json: bool = as_json("all runs as JSON")


@request("gap_report.effects:list_effects")
class GapEffectsRequest:
    """``bigant gap effects``: the catalogue of effects that a simulator may lack.

    Each effect with its stage, what it can act on, its numbers with units and bounds, its physics and its
    remedy. Without a run it is the legged robot's catalogue; with one that of its machine, whose bounds
    follow from its masses, limits and sensors. With --effects FILE.py your own effects are listed after
    them, which also checks the file (it is run as Python: open only files that you trust).
    """

    trial: Path | None = argument(
        "TRIAL", "a run of the machine (default: a legged robot)", nargs="?", default=None
    )
    machine: str = option(MACHINE, "FILE", default="")
    effects: Path | None = option("effects of your own", "FILE.py")
    stage: str | None = option("only those of one stage", "STAGE")
    json: bool = as_json("print JSON")
