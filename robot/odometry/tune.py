"""Noise of the estimator from logs: the values under which its own innovations are the most likely.

Likelihood needs forces but no truth. It is searched over logarithms, without gates, so that no setting can
win by refusing to listen.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import dropwhile, takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from model.errors import ModelError, RecordError
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.tick import Mode
from record.log.reader import LogContents, StampedTick, read_stamped_ticks
from record.whole_file import write_text
from robot.config.edit import with_estimator
from robot.config.robot_file import RobotConfig
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar
from robot.console.table import Column, table_lines
from robot.odometry.metrics import in_band
from robot.odometry.request import believed_robot
from robot.odometry.track import Track, track
from robot.requests.recorded import OdomRequest

NAMES = ("speed_per_slip", "turn_per_slip", "force_sd", "force_share_sd", "load_sd")
OF_GYRO, OF_TILT = "gyro_sd", "tilt_sd"  # tuned too, where the walks have them
# Settings may move this far from where they began; data that want more contradict the model.
FACTOR = 30.0
LONGEST_S = 30.0  # of each log
EVALUATIONS = 60


class TuningWalk(NamedTuple):
    """What a walk gives to tune by: ticks from the first one of walking on, and the robot to use."""

    ticks: tuple[StampedTick, ...]
    config: RobotConfig


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
    """Search the settings of ``tuned_names`` from ``start`` by at least one walk; all else stays."""
    names = tuned_names(walks)
    begin = np.log([getattr(start, name) for name in names])
    spent = 0

    def cost(point: FloatArray) -> float:
        nonlocal spent
        spent += 1
        progress(min(spent / EVALUATIONS, 1.0))
        far = np.abs(point - begin).max() - math.log(FACTOR)
        if far > 0:
            return float(1e9 * (1 + far))
        settings = _with(start, names, np.exp(point))
        return -sum(_likelihood(walk, settings) for walk in walks)

    simplex = np.vstack([begin, begin - 1.0 * np.eye(len(begin))])
    result = minimize(
        cost, begin, method="Nelder-Mead",
        options={"maxfev": EVALUATIONS, "initial_simplex": simplex, "xatol": 0.05, "fatol": 1.0},
    )  # fmt: skip
    return _with(start, names, [float(f"{value:.4g}") for value in np.exp(result.x)])


def tuned_names(walks: list[TuningWalk]) -> tuple[str, ...]:
    """Return the settings that some walks can tell of: an IMU's only where there was one."""
    readings = [
        reading for walk in walks for item in walk.ticks for reading in item.tick.inputs.imu
    ]
    rates = any(math.isfinite(one.yaw_rate_rad_s) for one in readings)
    tilts = any(math.isfinite(one.roll_rad) or math.isfinite(one.pitch_rad) for one in readings)
    return (*NAMES, *([OF_GYRO] if rates else []), *([OF_TILT] if tilts else []))


def _with(
    start: EstimatorSettings, names: tuple[str, ...], values: Iterable[float]
) -> EstimatorSettings:
    return replace(start, **dict(zip(names, map(float, values), strict=True)))  # type: ignore[arg-type]


def _likelihood(walk: TuningWalk, settings: EstimatorSettings) -> float:
    open_gates = replace(settings, gate_load=1e12, gate_pair=1e12)
    likelihood = _track(walk, open_gates).column("log_likelihood")
    return float(likelihood[np.isfinite(likelihood)].sum())


def _track(walk: TuningWalk, settings: EstimatorSettings) -> Track:
    """The stage over a walk, begun where the walking begins."""
    estimator = replace(walk.config.estimator, settings=settings)
    return track(walk.ticks, replace(walk.config, estimator=estimator))


def whiteness(walks: list[TuningWalk], settings: EstimatorSettings) -> Whiteness:
    """Look at the innovations under some settings, gates closed as usual.

    Raises:
        ModelError: No measurement was used.
    """
    ratios, bands, pairs, rejected = [], [], [], 0
    for walk in walks:
        run = _track(walk, settings)
        innovation = run.column("innovation")
        felt = np.isfinite(innovation).any(axis=(1, 2))  # an IMU is heard between forces as well
        nis, dof = run.column("nis")[felt], run.column("nis_dof")[felt]
        ratios.append(nis / dof)
        bands += [
            in_band(nis[dof == d], d) * int((dof == d).sum()) for d in set(dof[dof > 0].tolist())
        ]
        pairs.append((innovation[felt][:-1], innovation[felt][1:]))
        rejected += run.rejected
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


def tune_command(request: OdomRequest) -> ExitCode:
    """Tune by logs and report; the first log's robot file gets the tuned values.

    Raises:
        RecordError: A log cannot be read, or has no walking or no forces in it.
    """
    walks = [read_walk(path, request) for path in request.logs[1:]]
    config, names = walks[0].config, tuned_names(walks)
    start = config.estimator.settings
    before = whiteness(walks, start)
    with ProgressBar("tuning") as bar:
        settings = tune(walks, start, bar.show)
    after = whiteness(walks, settings)
    if request.out is not None:
        given = (
            {"law": start.law.value, "sway": start.sway} if request.law or request.no_sway else {}
        )
        values = {**given, **{name: getattr(settings, name) for name in names}}
        write_text(request.out, with_estimator(config.text, values))
    if request.json:
        tuned = {name: getattr(settings, name) for name in names}
        print_json({"settings": tuned, "before": before, "after": after})
        return ExitCode.OK
    columns = (Column("setting"), Column("before", ".4g"), Column("tuned", ".4g"))
    rows = [(name, getattr(start, name), getattr(settings, name)) for name in names]
    print(*table_lines(columns, rows), "", *_lines(before, after), sep="\n")
    if request.out is not None:
        print(f"written: {request.out}; bigant odom LOG --compare --robot {request.out} judges it")
    return ExitCode.OK


def _lines(before: Whiteness, after: Whiteness) -> list[str]:
    rows = [
        ("log likelihood", before.log_likelihood, after.log_likelihood),
        ("NIS per degree of freedom (1)", before.nis_over_dof, after.nis_over_dof),
        ("share in 95 % band", before.in_band, after.in_band),
        *(
            (f"lag-1 correlation F{axis} (0)", *values)
            for axis, *values in zip("xyz", before.lag_one, after.lag_one, strict=True)
        ),
    ]
    lines = table_lines(
        (Column("innovations"), Column("before", ".4g"), Column("tuned", ".4g")), rows
    )
    lines.append(
        f"white innovations stay within {after.white_band:.2g} of 0; "
        f"gates would reject {before.rejected} before, {after.rejected} tuned"
    )
    if np.nanmax(np.abs(after.lag_one)) > 3 * after.white_band:
        lines.append(
            "note: these innovations are not white: errors of the model last longer than a sample. "
            "Tuned values then trust the forces too much; check NEES with odom LOG --compare --robot FILE"
        )
    return lines


def read_walk(path: Path, request: OdomRequest) -> TuningWalk:
    """Read the walking part of a log, ``LONGEST_S`` at most.

    Raises:
        RecordError: It cannot be read, or has no walking or no forces in it.
    """
    contents = LogContents()
    walk = dropwhile(
        lambda item: item.tick.mode is not Mode.WALK, read_stamped_ticks(path, contents)
    )
    first = next(walk, None)
    if first is None:
        raise RecordError(f"{path} holds no walking; record a walk")
    end_ns = first.unix_ns + round(LONGEST_S * 1e9)
    ticks = [first, *takewhile(lambda item: item.unix_ns < end_ns, walk)]
    while ticks[-1].tick.mode is not Mode.WALK:
        ticks.pop()
    if not any(item.tick.forces.valid.any() for item in ticks):
        raise RecordError(f"{path} has no foot forces; tune by walks with the force unit")
    return TuningWalk(tuple(ticks), believed_robot(request, contents.config_text))
