"""``bigant gap demo``: runs of a deliberately faulty virtual robot and of a healthy one, diagnosed.

Nothing is done here that ``bigant sim run`` and ``bigant gap diagnose`` do not do: each step is one of
their requests, printed as the command that it stands for.
"""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.answer.named_cause import NamedCause, Value
from gap.interfaces import place_words
from gap.rounding import value_words
from gap.worker_pool import worker_pool
from model.errors import RecordError
from record.whole_file import writing
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.console.progress import ProgressBar
from robot.gap_report.diagnose import report_diagnosis
from robot.requests.gap import GapDemoRequest, GapDiagnoseRequest
from robot.requests.sim import SimRunRequest
from robot.virtual.twin_file import write_run
from robot.virtual.twin_run import make_twin
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import TwinEffect, find_kind, parse_effect

HEALTHY = "none"
FREQUENCIES_HZ = (0.1, 0.15)
# Seeds set the day of a run: those of the two robots must differ, as days do.
FIRST_HEALTHY_SEED, FIRST_FAULTY_SEED = 1, 11


@dataclass(frozen=True, slots=True)
class DemoRuns:
    """The runs of a demonstration: of the robot that is diagnosed, and of the healthy one."""

    trials: tuple[SimRunRequest, ...]
    references: tuple[SimRunRequest, ...]


def run_demo(request: GapDemoRequest) -> ExitCode:
    """Make the runs, diagnose them, and compare the answer with what was injected.

    Raises:
        ConfigError: The virtual robot has no such effect.
        RecordError: The folder is in use, or cannot be written.
        GapError: The runs cannot be compared with the simulator.
    """
    injected = _injected(request)
    runs = demo_runs(request)
    diagnose = _diagnosis_of(runs, request)
    _make_folder(request.out)
    count, healthy = len(runs.trials), len(runs.references)
    print(
        f"Step 1: {count} runs of a virtual robot with {_fault_words(injected)}, "
        f"{healthy} of a healthy one:"
    )
    _make(runs, request.jobs)
    print("\nStep 2: the diagnosis, which gets only the runs:")
    print(f"   {diagnose_words(diagnose)}\n", flush=True)
    diagnosis = report_diagnosis(diagnose)
    print("\nStep 3: the answer against what was injected:")
    lines, right = compared(injected, diagnosis)
    print(*(f"   {line}" for line in lines), sep="\n")
    return ExitCode.OK if right else ExitCode.VERDICT_FAILED


def _injected(request: GapDemoRequest) -> TwinEffect | None:
    """What is made wrong, checked before anything is made; None for a healthy robot."""
    if request.effect == HEALTHY:
        return None
    effect = parse_effect(request.effect, EFFECTS)
    make_twin(load_robot(request.robot), (effect,), FIRST_FAULTY_SEED)
    return effect


def _make_folder(folder: Path) -> None:
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise RecordError(
            f"--out {folder} is there already; name another folder, or remove it first"
        )
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)


def demo_runs(request: GapDemoRequest) -> DemoRuns:
    """Return what is walked: both robots walk each gait at each frequency, each time on another day."""
    gaits = tuple(one.name for one in load_robot(request.robot).parameters.gaits)[:2]
    walks = [(gait, hertz) for hertz in FREQUENCIES_HZ for gait in gaits]
    wrong = () if request.effect == HEALTHY else (request.effect,)

    def made(name: str, first_seed: int, effect: tuple[str, ...]) -> tuple[SimRunRequest, ...]:
        return tuple(
            SimRunRequest(
                robot=request.robot,
                gait=gait,
                frequency_hz=hertz,
                effect=effect,
                seed=first_seed + number,
                seconds=request.seconds,
                out=request.out / f"{name}_{number + 1}.parquet",
                fast=True,
            )
            for number, (gait, hertz) in enumerate(walks)
        )

    return DemoRuns(
        made("trial", FIRST_FAULTY_SEED, wrong), made("healthy", FIRST_HEALTHY_SEED, ())
    )


def _diagnosis_of(runs: DemoRuns, request: GapDemoRequest) -> GapDiagnoseRequest:
    return GapDiagnoseRequest(
        trials=tuple(one.out for one in runs.trials),
        reference=tuple(one.out for one in runs.references),
        json=request.out / "diagnosis.json",
        html=request.out / "diagnosis.html",
        jobs=request.jobs,
    )


def _make(runs: DemoRuns, jobs: int) -> None:
    """Walk all runs, several at a time, and print the command that each is."""
    requests = (*runs.trials, *runs.references)
    for one in requests:
        print(f"   {shlex.join(run_words(one))}", flush=True)
    with ProgressBar("walking") as bar, nullcontext() if jobs == 1 else worker_pool(jobs) as pool:
        done = map(_walk, requests) if pool is None else pool.map(_walk, requests)
        for number, _ in enumerate(done, start=1):
            bar.show(number / len(requests), f"{number} of {len(requests)} runs")


def _walk(request: SimRunRequest) -> None:
    write_run(request)


def run_words(one: SimRunRequest) -> list[str]:
    """Return the command of a run, as it is typed."""
    words = ["bigant", "sim", "run", *_robot_words(one.robot)]
    words += ["--gait", str(one.gait), "--frequency-hz", f"{one.frequency_hz:g}"]
    words += [word for effect in one.effect for word in ("--effect", effect)]
    words += (
        []
        if one.seconds == SimRunRequest(out=one.out).seconds
        else ["--seconds", f"{one.seconds:g}"]
    )
    return [*words, "--seed", str(one.seed), "--fast", "--out", str(one.out)]


def diagnose_words(one: GapDiagnoseRequest) -> str:
    """Return the command of a diagnosis, as it is typed: a shell fills in the names of the runs."""
    trials, references = (
        f"{shlex.quote(str(paths[0].parent))}/{paths[0].name.partition('_')[0]}_*.parquet"
        for paths in (one.trials, one.reference)
    )
    words = f"bigant gap diagnose {trials} --reference {references}"
    return f"{words} --json {shlex.quote(str(one.json))} --html {shlex.quote(str(one.html))}"


def _robot_words(robot: Path) -> list[str]:
    return [] if robot == DEFAULT_ROBOT_FILE else ["--robot", str(robot)]


def _fault_words(effect: TwinEffect | None) -> str:
    if effect is None:
        return "nothing wrong"
    sizes = ", ".join(f"{name} {value:g}" for name, value in _sizes(effect))
    return place_words(effect.name, _legs(effect)) + f" ({sizes})" * bool(sizes)


def _legs(effect: TwinEffect) -> tuple[str, ...]:
    return (effect.leg,) if effect.leg else ()


def _sizes(effect: TwinEffect) -> Iterator[tuple[str, float]]:
    """The numbers of an effect that change something."""
    kind = find_kind(effect.name, EFFECTS)
    for parameter, value in zip(kind.parameters, effect.values, strict=True):
        if value != parameter.neutral:
            yield parameter.name, value


def compared(effect: TwinEffect | None, d: Diagnosis) -> tuple[list[str], bool]:
    """Return what was injected beside what was found, in lines, and whether the answer is right.

    It is right where the one cause that was injected is named with its leg, and nothing else; where a
    healthy robot has no gap, and where an effect that the catalogue does not have is left unexplained.
    """
    named = " and ".join(one.words for one in d.causes) or "nothing"
    verdict = d.verdict.headline
    lines = [f"injected  {_fault_words(effect)}", f"found     {named} ({verdict})"]
    if effect is None:
        right = d.verdict is Verdict.NO_GAP
        return [*lines, "right: nothing is wrong" if right else "wrong: a false alarm"], right
    if not find_kind(effect.name, EFFECTS).catalogued:
        right = d.verdict is Verdict.UNEXPLAINED
        return [*lines, f"{_right(right)}: the diagnosis does not know {effect.name}"], right
    same = [one for one in d.causes if (one.effect, one.joints) == (effect.name, _legs(effect))]
    if not same:
        return [*lines, f"wrong: it was {place_words(effect.name, _legs(effect))}"], False
    right = d.verdict is Verdict.EXPLAINED and len(d.causes) == 1
    lines += [f"{_right(right)}: {_judged(same[0], d)}"]
    return [*lines, *_size_lines(same[0], dict(_sizes(effect)))], right


def _right(right: bool) -> str:
    return "right" if right else "not right"


def _judged(cause: NamedCause, d: Diagnosis) -> str:
    where = "fault and leg are" if cause.joints else "the fault is"
    if d.verdict is not Verdict.EXPLAINED:
        return f"{where} named, but the verdict is {d.verdict.headline}"
    if len(d.causes) > 1:
        return f"{where} named, but so is what was not injected"
    return f"{where} those that were injected" if cause.joints else "that is what was injected"


def _size_lines(cause: NamedCause, true: dict[str, float]) -> Sequence[str]:
    """Each number that was injected beside the one found, in units of its error."""
    values = {one.name: one for one in cause.values}
    return [_size_line(values[name], value) for name, value in true.items() if name in values]


def _size_line(fitted: Value, true: float) -> str:
    words = value_words(fitted.value, fitted.error, fitted.unit)
    off = abs(fitted.value - true) / fitted.error if fitted.error > 0.0 else float("inf")
    within = "within its error" if off <= 1.0 else f"{off:.1f} times its error away"
    return f"{fitted.name}: {words} found, {true:g} injected: {within}"
