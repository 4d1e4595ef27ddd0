"""How visible the effects of a campaign's cases are, and what their true values would close.

The twin walks every case once more on the same days without its effects. The difference is what the
effects change; how much healthy walks of different days differ is repeatability. Used for scoring, after
the labels are open, and by nothing that diagnoses.
"""

import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gap.interfaces import Cause, Simulator
from gap.reachable import shrink_of
from gap.score import PAIR, SINGLE
from model.signals import FloatArray
from robot.campaign_plan import Scenario, read_scenario
from robot.config import load_robot
from robot.gap_campaign import CaseFiles, Label
from robot.gap_case import Asked, read_case
from robot.progress import ProgressBar
from robot.twin_run import make_twin, walk_fast

if TYPE_CHECKING:
    from record.trial import Trial


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
        healthy: Healthy values of each trial, (F, C) each.
        reachable: See ``Seen``.
    """

    name: str
    change: FloatArray
    healthy: tuple[FloatArray, ...]
    reachable: float


def seen_of(
    files: Sequence[CaseFiles],
    labels: Mapping[str, Label],
    scenario: Path,
    out: Path,
    jobs: int,
) -> dict[str, Seen]:
    """Measure every case with something wrong.

    Args:
        files: Cases.
        labels: Their labels.
        scenario: Scenario file of the campaign.
        out: Where the figures are kept.
        jobs: Processes.

    Raises:
        ConfigError: The scenario file cannot be used.
    """
    kept = out / "seen.json"
    if kept.is_file():
        return {name: Seen(*_floats(pair)) for name, pair in json.loads(kept.read_text()).items()}
    plan = read_scenario(scenario)
    wanted = [one for one in files if labels[one.name].kind in {SINGLE, PAIR}]
    oracles: list[_Oracle] = []
    with (
        ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool,
        ProgressBar("oracle") as bar,
    ):
        futures = [pool.submit(_ask_oracle, one, labels[one.name], plan) for one in wanted]
        for number, done in enumerate(as_completed(futures)):
            oracles.append(done.result())
            bar.show((number + 1) / len(wanted), f"{number + 1} of {len(wanted)}")
    spread = _repeatability(oracles)
    seen = {
        one.name: Seen(_largest(np.sqrt(np.nanmean(one.change / spread, axis=0))), one.reachable)
        for one in oracles
    }
    told = {name: [_null(s.visible), _null(s.reachable)] for name, s in sorted(seen.items())}
    kept.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    return seen


def _ask_oracle(files: CaseFiles, label: Label, scenario: Scenario) -> _Oracle:
    trials, references, simulator = read_case(Asked(files.trials, files.references, (), Path()))
    config = load_robot(scenario.robots[label.robot])
    change, healthy = [], []
    for trial, plan, seed in zip(trials, scenario.plans, label.seeds, strict=True):
        walk = walk_fast(config, make_twin(config, (), seed), plan, lambda _: None)
        ill, well = _values(simulator, trial), _values(simulator, walk)
        n = min(len(ill), len(well))
        change.append(_mean_square(ill[:n] - well[:n]))
        healthy.append(well)
    causes = _causes(simulator, label)
    reachable = shrink_of(trials, simulator, references, causes) if causes else math.nan
    return _Oracle(files.name, np.array(change), tuple(healthy), reachable)


def _values(simulator: Simulator, trial: "Trial") -> FloatArray:
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


def _repeatability(oracles: Sequence[_Oracle]) -> FloatArray:
    """Return the variance of each trial's channels from day to day, (R, C)."""
    rows = []
    for trial in range(len(oracles[0].healthy)):
        n = min(len(one.healthy[trial]) for one in oracles)
        stack = np.array([one.healthy[trial][:n] for one in oracles])
        rows.append(np.nanmean(np.nanvar(stack, axis=0, ddof=1), axis=0))
    return np.array(rows)


def _mean_square(values: FloatArray) -> FloatArray:
    known = np.isfinite(values)
    total = np.where(known, values, 0.0) ** 2
    return np.asarray(total.sum(axis=0) / np.maximum(known.sum(axis=0), 1))


def _largest(values: FloatArray) -> float:
    return float(np.nanmax(values))


def _null(value: float) -> float | None:
    return None if math.isnan(value) else value


def _floats(pair: Sequence[float | None]) -> list[float]:
    return [math.nan if value is None else value for value in pair]
