"""How visible the effects of a campaign's cases are, and what their true values would close.

What an effect changes is told by the campaign's controls, or, with its scenario file, by the twin, which
walks every case once more on the same days without its effects. How much healthy walks of different days
differ is repeatability. Used for scoring, after the labels are open, and by nothing that diagnoses.
"""

import contextlib
import json
import math
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gap.check.score import CONTROL, PAIR, SINGLE
from gap.diagnosis.how_far import how_far
from gap.diagnosis.study import make_study
from gap.interfaces import Cause, Simulator
from gap.worker_pool import worker_pool
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from robot.campaign.case import Asked, read_case
from robot.campaign.folder import CaseFiles, Label, keep_json
from robot.campaign.plan import Scenario, read_scenario
from robot.config.robot_file import load_robot
from robot.console.progress import ProgressBar
from robot.virtual.twin_run import make_twin, walk_fast

FEWEST_CONTROLS = 5  # that tell how healthy walks differ


@dataclass(frozen=True, slots=True)
class Seen:
    """What an oracle knows of a case.

    Attributes:
        visible: Largest RMS change of any channel over its repeatability.
        reachable: Share that the true effects with true values close; NaN where the catalogue has none.
    """

    visible: float
    reachable: float


@dataclass(frozen=True, slots=True, eq=False)
class _Oracle:
    """One case by the oracle: mean squares of its changes, and the healthy walks themselves.

    Attributes:
        name: Of the case.
        change: Mean square change of each trial and channel, (R, C).
        healthy: Healthy values of each trial, (F, C) each; none where controls tell.
        reachable: See ``Seen``.
    """

    name: str
    change: FloatArray
    healthy: tuple[FloatArray, ...]
    reachable: float


@dataclass(frozen=True, slots=True, eq=False)
class _Usual:
    """What healthy walks of one trial show: their mean, and their variance from day to day, (F, C)."""

    mean: FloatArray
    variance: FloatArray
    walks: int


def seen_of(
    files: Sequence[CaseFiles],
    labels: Mapping[str, Label],
    scenario: Path | None,
    out: Path,
    jobs: int,
    standing: tuple[Cause, ...],
) -> dict[str, Seen]:
    """Measure every case with something wrong.

    Args:
        files: Cases.
        labels: Their labels.
        scenario: Scenario file of the campaign; None: its controls tell, and nothing is measured if there
            are fewer than ``FEWEST_CONTROLS``.
        out: Where the figures are kept.
        jobs: Processes.
        standing: What the references show already.

    Raises:
        ConfigError: The scenario file cannot be used.
    """
    kept = out / "seen.json"
    if kept.is_file():
        return {name: Seen(*_floats(pair)) for name, pair in json.loads(kept.read_text()).items()}
    if scenario is None:
        if sum(labels[one.name].kind == CONTROL for one in files) < FEWEST_CONTROLS:
            return {}
        usual = _usual_walks([one for one in files if labels[one.name].kind == CONTROL])
        plan = None
    else:
        usual, plan = (), read_scenario(scenario)
    wanted = [one for one in files if labels[one.name].kind in {SINGLE, PAIR}]
    oracles: list[_Oracle] = []
    with worker_pool(jobs) as pool, ProgressBar("oracle") as bar:
        futures = [
            pool.submit(_ask_oracle, one, labels[one.name], standing, plan, usual) for one in wanted
        ]
        for number, done in enumerate(as_completed(futures)):
            oracles.append(done.result())
            bar.show((number + 1) / len(wanted), f"{number + 1} of {len(wanted)}")
    spread = _days(usual or _usual_of([one.healthy for one in oracles]))
    seen = {
        one.name: Seen(_largest(np.sqrt(np.nanmean(one.change / spread, axis=0))), one.reachable)
        for one in oracles
    }
    keep_json({name: (s.visible, s.reachable) for name, s in sorted(seen.items())}, kept)
    return seen


def _usual_walks(controls: Sequence[CaseFiles]) -> tuple[_Usual, ...]:
    rows = []
    for one in controls:
        trials, _, simulator = read_case(Asked(one.trials, (), (), Path()))
        rows.append([_values(simulator, trial) for trial in trials])
    return _usual_of(rows)


def _usual_of(walks: Sequence[Sequence[FloatArray]]) -> tuple[_Usual, ...]:
    """Return what healthy walks show, one a trial; each walk has its trials' values, (F, C) each."""
    found = []
    for same in zip(*walks, strict=True):
        n = min(map(len, same))
        stack = np.array([one[:n] for one in same])
        with warnings.catch_warnings():
            # ends of a trial are compared by nobody
            warnings.simplefilter("ignore", RuntimeWarning)
            mean, variance = np.nanmean(stack, axis=0), np.nanvar(stack, axis=0, ddof=1)
        found.append(_Usual(mean, variance, len(same)))
    return tuple(found)


def _days(usual: Sequence[_Usual]) -> FloatArray:
    """Return the variance of each trial's channels from day to day, (R, C)."""
    return np.array([np.nanmean(one.variance, axis=0) for one in usual])


def _ask_oracle(
    files: CaseFiles,
    label: Label,
    standing: tuple[Cause, ...],
    scenario: Scenario | None,
    usual: tuple[_Usual, ...],
) -> _Oracle:
    trials, references, simulator = read_case(Asked(files.trials, files.references, (), Path()))
    change: list[FloatArray] = []
    healthy: list[FloatArray] = []
    for trial, known in zip(trials, usual, strict=scenario is None):
        values = _values(simulator, trial)
        n = min(len(values), len(known.mean))
        beyond = (values[:n] - known.mean[:n]) ** 2 - known.variance[:n] * (1 + 1 / known.walks)
        change.append(np.fmax(_mean_known(beyond), 0.0))
    if scenario is not None:
        change, healthy = _walked_again(simulator, trials, label, scenario)
    causes = _causes(simulator, label)
    reachable = math.nan
    if causes:
        # a truth beyond the bounds of the catalogue cannot be reached, and is counted without
        with contextlib.suppress(GapError):
            study = make_study(trials, simulator, references).with_standing(standing)
            reachable = how_far(study.held_evidence(), causes, seed=0).shrink
    return _Oracle(files.name, np.array(change), tuple(healthy), reachable)


def _walked_again(
    simulator: Simulator, trials: Sequence[Trial], label: Label, scenario: Scenario
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Mean square changes, and healthy values, by the twin on the same days."""
    config = load_robot(scenario.robots[label.robot])
    change, healthy = [], []
    for trial, plan, seed in zip(trials, scenario.plans, label.seeds, strict=True):
        walk = walk_fast(config, make_twin(config, (), seed), plan, lambda _: None)
        ill, well = _values(simulator, trial), _values(simulator, walk)
        n = min(len(ill), len(well))
        change.append(_mean_known((ill[:n] - well[:n]) ** 2))
        healthy.append(well)
    return change, healthy


def _values(simulator: Simulator, trial: Trial) -> FloatArray:
    observed = simulator.observe(trial)
    return np.where(observed.weight > 0, observed.values, np.nan)


def _causes(simulator: Simulator, label: Label) -> tuple[Cause, ...]:
    effects = {effect.name: effect for effect in simulator.effects}
    if any(truth.effect not in effects for truth in label.truths):
        return ()
    return tuple(
        Cause(
            truth.effect,
            (truth.joint,) if truth.joint else (),
            tuple(dict(truth.values)[p.name] for p in effects[truth.effect].parameters),
        )
        for truth in label.truths
    )


def _mean_known(values: FloatArray) -> FloatArray:
    """Mean over the frames that are known, (F, C) to (C,); 0 where none is."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=0)
    return np.asarray(total / np.maximum(known.sum(axis=0), 1))


def _largest(values: FloatArray) -> float:
    return float(np.nanmax(values))


def _floats(pair: Sequence[float | None]) -> list[float]:
    return [math.nan if value is None else value for value in pair]
