"""How visible the effects of a campaign's cases are, and what their true values would close.

What an effect changes is measured against the campaign's controls, or, with its scenario file, against the
twin, which walks every case once more on the same days without its effects. How much healthy walks of
different days differ is repeatability. Used for scoring, after the labels are open, and by nothing that
diagnoses.
"""

import contextlib
import math
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gap.check.cases import CONTROL, PAIR, SINGLE
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.comparison.how_far import how_far
from gap.interfaces import Cause, Simulator
from model.errors import GapError, RecordError
from model.values.arrays import FloatArray
from record.json_text import read_json
from record.trial.trial import Trial
from robot.campaign.case import CaseFiles, Label, keep_json, read_case
from robot.campaign.plan import CampaignScenario
from robot.console.progress import ProgressBar
from robot.virtual.twin_run import make_twin, walk_fast

FEWEST_CONTROLS = 5  # that show how healthy walks differ


class Visibility(NamedTuple):
    """What only the labels tell of a case.

    Attributes:
        visible: Largest RMS change of any channel over its repeatability.
        reachable: Share that the true effects with true values close; NaN where the catalogue has none.
    """

    visible: float
    reachable: float


UNKNOWN = Visibility(math.nan, math.nan)


class _Change(NamedTuple):
    """What the effects of one case change: mean squares of each trial and channel, (R, C).

    With the healthy values of each trial, (F, C) each, where the twin walked them.
    """

    name: str
    squares: FloatArray
    healthy: list[FloatArray]
    reachable: float


class _Healthy(NamedTuple):
    """Healthy walks of one trial: their mean, and their variance from day to day, (F, C)."""

    mean: FloatArray
    variance: FloatArray
    walks: int


def measure_visibility(
    files: Sequence[CaseFiles],
    labels: Mapping[str, Label],
    scenario: CampaignScenario | None,
    out: Path,
    executor: Executor,
    standing: tuple[Cause, ...],
) -> dict[str, Visibility]:
    """Measure every case with something wrong, in several processes, and keep the figures in ``out``.

    Without the scenario file of the campaign it is compared with its controls, and nothing is measured if
    there are fewer than ``FEWEST_CONTROLS``. ``standing`` is what the references show already.

    Raises:
        RecordError: The file of kept figures is damaged.
    """
    kept = out / "seen.json"
    if kept.is_file():
        try:
            return {
                name: Visibility(*(math.nan if value is None else float(value) for value in pair))
                for name, pair in read_json(kept).items()
            }
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise RecordError(f"{kept}: {error!r}; delete it to measure again") from error
    plan = scenario
    healthy: list[_Healthy] = []
    if plan is None:
        controls = [one for one in files if labels[one.name].kind == CONTROL]
        if len(controls) < FEWEST_CONTROLS:
            return {}
        healthy = _healthy([_control_values(one) for one in controls])
    wanted = [one for one in files if labels[one.name].kind in {SINGLE, PAIR}]
    changes: list[_Change] = []
    with ProgressBar("oracle") as bar:
        futures = [
            executor.submit(_change, one, labels[one.name], standing, plan, healthy)
            for one in wanted
        ]
        for number, done in enumerate(as_completed(futures), 1):
            changes.append(done.result())
            bar.show(number / len(wanted), f"{number} of {len(wanted)}")
    healthy = healthy or _healthy([one.healthy for one in changes])
    spread = np.array([np.nanmean(one.variance, axis=0) for one in healthy])  # (R, C)
    spread[spread == 0.0] = np.inf  # nothing is told by what no healthy robot does at all
    visibility = {}
    for one in sorted(changes, key=lambda change: change.name):
        rms = np.sqrt(np.nanmean(one.squares / spread, axis=0))
        visibility[one.name] = Visibility(float(np.nanmax(rms)), one.reachable)
    keep_json(visibility, kept)
    return visibility


def _control_values(control: CaseFiles) -> list[FloatArray]:
    runs, simulator = read_case(control.trials)
    return [_values(simulator, trial) for trial in runs.trials]


def _healthy(walks: Sequence[Sequence[FloatArray]]) -> list[_Healthy]:
    """Return what healthy walks show, one a trial; each walk has its trials' values, (F, C) each."""
    shown = []
    for same in zip(*walks, strict=True):
        n = min(map(len, same))
        stack = np.array([one[:n] for one in same])
        with warnings.catch_warnings():
            # ends of a trial are compared by nobody
            warnings.simplefilter("ignore", RuntimeWarning)
            mean, variance = np.nanmean(stack, axis=0), np.nanvar(stack, axis=0, ddof=1)
        shown.append(_Healthy(mean, variance, len(same)))
    return shown


def _change(
    files: CaseFiles,
    label: Label,
    standing: tuple[Cause, ...],
    scenario: CampaignScenario | None,
    healthy: Sequence[_Healthy],
) -> _Change:
    runs, simulator = read_case(files.trials, files.references)
    values = [_values(simulator, trial) for trial in runs.trials]
    squares: list[FloatArray] = []
    walked: list[FloatArray] = []
    if scenario is None:
        for ill, known in zip(values, healthy, strict=True):
            n = min(len(ill), len(known.mean))
            beyond = (ill[:n] - known.mean[:n]) ** 2 - known.variance[:n] * (1 + 1 / known.walks)
            squares.append(np.fmax(_mean_known(beyond), 0.0))
    else:  # the same days by the twin, without the effects
        config, reality = scenario.config(label.robot), scenario.reality
        for ill, plan, seed in zip(values, scenario.plans, label.seeds, strict=True):
            walk = walk_fast(config, make_twin(config, (), seed, reality), plan, lambda _: None)
            well = _values(simulator, walk)
            n = min(len(ill), len(well))
            squares.append(_mean_known((ill[:n] - well[:n]) ** 2))
            walked.append(well)
    causes = _causes(simulator, label)
    reachable = math.nan
    if causes:
        # a truth beyond the bounds of the catalogue cannot be reached, and is counted without
        with contextlib.suppress(GapError):
            study = commissioned_study(runs.trials, simulator, runs.references, standing=standing)
            reachable = how_far(study.held_evidence(), causes, seed=0).shrink
    return _Change(files.name, np.array(squares), walked, reachable)


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
