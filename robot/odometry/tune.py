"""Noise of the estimator from logs: the values under which its own innovations are the most likely.

Likelihood needs forces but no truth. It is searched over logarithms, without gates, so that no setting can
win by refusing to listen.
"""

import argparse
import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from model.errors import ConfigError, ModelError, RecordError
from model.estimator.settings import EstimatorSettings
from model.parameters.robot import ContactParameters
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.estimate import OdometryInputs
from robot.console.exit_codes import ExitCode
from robot.odometry.metrics import in_band
from robot.odometry.track import OdometryTrack, track

NAMES = ("speed_per_slip", "turn_per_slip", "force_sd", "force_share_sd", "load_sd")
# Settings may move this far from where they began; data that want more contradict the model.
FACTOR = 30.0
LONGEST_S = 30.0  # of each log
EVALUATIONS = 60


@dataclass(frozen=True, slots=True, eq=False)
class TuningWalk:
    """What a walk gives to tune by."""

    inputs: tuple[OdometryInputs, ...]
    contact: ContactParameters
    weight_n: float


@dataclass(frozen=True, slots=True, eq=False)
class Whiteness:
    """What the innovations look like: nothing to learn from them is the aim.

    Attributes:
        log_likelihood: Sum over all walks.
        nis_over_dof: Mean; 1 is ideal.
        in_band: Share of updates whose NIS lies in the 95 % band.
        lag_one: Correlation of each innovation with the one before, Fx, Fy, Fz, (3,); 0 is ideal.
        white_band: Correlations within this of 0 are what white innovations would show.
        rejected: Measurements that the gates would reject.
    """

    log_likelihood: float
    nis_over_dof: float
    in_band: float
    lag_one: FloatArray
    white_band: float
    rejected: int


def tune(
    walks: list[TuningWalk], start: EstimatorSettings, progress: Callable[[float], None]
) -> EstimatorSettings:
    """Search the settings of ``NAMES`` from ``start``.

    Args:
        walks: At least one.
        start: Where the search begins; everything else stays.
        progress: Told the share done.
    """
    begin = np.log([getattr(start, name) for name in NAMES])
    spent = 0

    def cost(point: FloatArray) -> float:
        nonlocal spent
        spent += 1
        progress(min(spent / EVALUATIONS, 1.0))
        far = np.abs(point - begin).max() - math.log(FACTOR)
        if far > 0:
            return float(1e9 * (1 + far))
        settings = _with(start, point)
        total = 0.0
        for walk in walks:
            total -= _likelihood(walk, settings)
        return total

    simplex = np.vstack([begin, begin - 1.0 * np.eye(len(begin))])
    found = minimize(
        cost, begin, method="Nelder-Mead",
        options={"maxfev": EVALUATIONS, "initial_simplex": simplex, "xatol": 0.05, "fatol": 1.0},
    )  # fmt: skip
    return _with(start, np.asarray(found.x))


def _with(start: EstimatorSettings, point: FloatArray) -> EstimatorSettings:
    values = {name: float(np.exp(v)) for name, v in zip(NAMES, point, strict=True)}
    return replace(start, **values)  # type: ignore[arg-type]  # all of them are numbers


def _likelihood(walk: TuningWalk, settings: EstimatorSettings) -> float:
    open_gates = replace(settings, gate_load=1e12, gate_pair=1e12)
    run = _track(walk, open_gates)
    said = np.array([e.log_likelihood for e in run.estimates])
    return float(said[np.isfinite(said)].sum())


def _track(walk: TuningWalk, settings: EstimatorSettings) -> OdometryTrack:
    return track(list(walk.inputs), walk.contact, walk.weight_n, settings)


def whiteness(walks: list[TuningWalk], settings: EstimatorSettings) -> Whiteness:
    """Look at the innovations under some settings, gates closed as usual.

    Raises:
        ModelError: No measurement was used.
    """
    ratios, bands, pairs, rejected = [], [], [], 0
    for walk in walks:
        run = _track(walk, settings)
        used = run.nis_dof > 0
        ratios.append(run.nis[used] / run.nis_dof[used])
        bands += [
            in_band(run.nis[used & (run.nis_dof == d)], float(d))
            * int((used & (run.nis_dof == d)).sum())
            for d in np.unique(run.nis_dof[used]).tolist()
        ]
        innovation = np.array([e.innovation for e in run.estimates])[used]
        pairs.append((innovation[:-1], innovation[1:]))
        rejected += run.estimates[-1].rejects
    ratio = np.concatenate(ratios)
    if not len(ratio):
        raise ModelError("no force was used: tune by logs of walks with the force unit")
    before, after = (np.concatenate(part) for part in zip(*pairs, strict=True))
    both = np.isfinite(before) & np.isfinite(after)
    product = np.where(both, before * after, 0.0).sum(axis=(0, 1))
    size = np.where(both, (before**2 + after**2) / 2, 0.0).sum(axis=(0, 1))
    return Whiteness(
        log_likelihood=sum(_likelihood(walk, settings) for walk in walks),
        nis_over_dof=float(ratio.mean()),
        in_band=sum(bands) / len(ratio),
        lag_one=np.where(size > 0, product / np.where(size > 0, size, 1.0), np.nan),
        white_band=1.96 / math.sqrt(max(int(both.sum()) / 3, 1)),
        rejected=rejected,
    )


def tune_command(paths: list[Path], options: argparse.Namespace) -> ExitCode:
    """Tune by logs and report.

    Raises:
        RecordError: A log cannot be read, or has no walking or no forces in it.
    """
    start = EstimatorSettings(law=FrictionLaw(options.law or "coulomb"), sway=not options.no_sway)
    walks = [_read(path, options.robot) for path in paths]

    def progress(share: float) -> None:
        if sys.stderr.isatty():
            print(f"\rtuning {100 * share:3.0f} %", end="", file=sys.stderr, flush=True)

    before = whiteness(walks, start)
    settings = tune(walks, start, progress)
    after = whiteness(walks, settings)
    if options.json:
        print(json.dumps(_as_json(settings, before, after), indent=2))
        return ExitCode.OK
    if sys.stderr.isatty():
        print(file=sys.stderr)
    print(f"{'setting':<22}{'before':>12}{'tuned':>12}")
    for name in NAMES:
        print(f"{name:<22}{getattr(start, name):>12.4g}{getattr(settings, name):>12.4g}")
    print(*_lines(before, after), sep="\n")
    return ExitCode.OK


def _lines(before: Whiteness, after: Whiteness) -> list[str]:
    rows = (
        ("log likelihood", before.log_likelihood, after.log_likelihood),
        ("NIS over its numbers (1)", before.nis_over_dof, after.nis_over_dof),
        ("share in 95 % band", before.in_band, after.in_band),
        ("lag-1 correlation Fx (0)", before.lag_one[0], after.lag_one[0]),
        ("lag-1 correlation Fy (0)", before.lag_one[1], after.lag_one[1]),
        ("lag-1 correlation Fz (0)", before.lag_one[2], after.lag_one[2]),
    )
    lines = [f"{name:<26}{was:>12.4g}{now:>12.4g}" for name, was, now in rows]
    lines.append(
        f"white innovations stay within {after.white_band:.2g} of 0; "
        f"gates would reject {before.rejected} before, {after.rejected} tuned"
    )
    if np.nanmax(np.abs(after.lag_one)) > 3 * after.white_band:
        lines.append(
            "note: these innovations are not white: errors of the model last longer than a sample. "
            "Tuned values then trust the forces too much; check NEES with odom LOG --compare"
        )
    return lines


def _as_json(settings: EstimatorSettings, before: Whiteness, after: Whiteness) -> dict[str, object]:
    def plain(found: Whiteness) -> dict[str, object]:
        return {
            "log_likelihood": found.log_likelihood,
            "nis_over_dof": found.nis_over_dof,
            "in_band": found.in_band,
            "lag_one": [float(v) if math.isfinite(v) else None for v in found.lag_one],
            "white_band": found.white_band,
            "rejected": found.rejected,
        }

    return {
        "settings": {name: getattr(settings, name) for name in NAMES},
        "before": plain(before),
        "after": plain(after),
    }


def _read(path: Path, robot: Path | None) -> TuningWalk:
    from record.log.reader import read_log
    from robot.config.robot_file import load_robot, parse_robot
    from robot.odometry.compare import walking_part
    from robot.odometry.track import feet_of, inputs_of, weight_of

    log = read_log(path)
    if not np.isfinite(log.force_n).any():
        raise RecordError(f"{path} has no foot forces; tune by walks with the force unit")
    if robot is not None:
        config = load_robot(robot)
    else:
        config = parse_robot(log.config_text) if log.config_text else load_robot()
    if config.effects:
        raise ConfigError(
            "effects", "odom tune knows none of them; give a robot file without, --robot"
        )
    first, last = walking_part(log)
    last = min(last, int(np.searchsorted(log.t_s, log.t_s[first] + LONGEST_S)))
    inputs = tuple(inputs_of(log, feet_of(log, config), first, last))
    return TuningWalk(inputs, config.parameters.contact, weight_of(config))
