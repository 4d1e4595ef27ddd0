"""Requests of ``bigant model``: the model of slipping, without a robot."""

from pathlib import Path

from robot.console.arguments import (
    argument,
    as_json,
    between,
    flag,
    gait_choice,
    option,
    random_seed,
    request,
    robot_file,
    several,
)
from robot.console.shipped import shipped

# spelled out here so that the parser imports nothing heavy; robot.study.systems knows how to build
SYSTEM_NAMES = ("bigant", "disk", "multipod", "quadruped", "stairs", "slither")
LAW_NAMES = ("viscous", "coulomb", "both")


@request("study.model_run:run_model", writes=True)
class ModelRunRequest:
    """``bigant model run``: predict the motion of a named system; a table and a picture."""

    system: str = argument("SYSTEM", ", ".join(SYSTEM_NAMES), choices=SYSTEM_NAMES)
    legs: int | None = option("legs of a disk or multipod, contacts of slither", "N")
    gait: str | None = gait_choice()
    robot: Path | None = option("robot file of bigant", "FILE")
    cycles: float | None = option("length of the motion", "N")
    law: str = option("friction (viscous)", choices=LAW_NAMES, default="viscous")
    tilt_coupling: bool = flag("feet's vertical speed pushes a tilted body sideways")
    out: Path | None = option(".png or .html (model_SYSTEM.png)", "FILE")
    json: bool = as_json("print JSON; no picture without --out")


@request("study.sensitivity:judge_sensitivity", writes=True)
class ModelSensitivityRequest:
    """``bigant model sensitivity``: naive against fitted parameters on logs (the paper's sec:tripod).

    Fit stiffness and friction to the first half of a log (of several logs: to the first log), and compare
    the errors of fitted and naive parameters on the rest.
    """

    logs: tuple[Path, ...] = argument("LOG", nargs="+")
    form: int = option(
        "18 parameters, w fore and aft, or 24, w free (default: 18)", choices=(18, 24), default=18
    )
    law: str = option(
        "the paper's viscous ansatz or Coulomb's law (default: viscous)",
        choices=("viscous", "coulomb"),
        default="viscous",
    )
    rest_mm_s: float = option(
        "leave feet no faster than this out of the friction fit (default: 1)",
        "V",
        default=1.0,
        type=between(0),
    )
    out: Path | None = option("draw the changes as well", "FILE.png")
    json: bool = as_json()


@request("study.figure_catalog:draw_figures", writes=True)
class ModelFiguresRequest:
    """``bigant model figures``: our version of every figure of the paper that needs no unpublished data."""

    out: Path | None = option("folder for pictures and index.html", "DIR")
    only: tuple[str, ...] = several("draw only this figure; may be given several times", "NAME")
    list: bool = flag("list the figures and end")
    tripod: Path | None = option("use this log in place of a virtual tripod walk", "LOG")
    metachronal: Path | None = option("use this log in place of a virtual metachronal walk", "LOG")
    cycles: float = option("cycles of each virtual walk (default: 3)", "N", default=3.0)
    seed: int = random_seed("seed of the virtual robot", None)
    robot: Path = robot_file("robot file of the virtual walks (default: config/bigant.toml)")
    benchmark: Path = option(
        "file of benchmark figures",
        "FILE",
        default=shipped("docs/figures/model_benchmark.json"),
    )
