"""What ``bigant sim run`` does: a walk of a twin into a trial or a log."""

import time

from model.errors import ConfigError
from record.trial.trial import Trial, write_trial
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar
from robot.requests.sim import SimRunRequest
from robot.virtual.reality_robot import robot_in
from robot.virtual.rehearsal import Progress, silent
from robot.virtual.twin_run import WalkPlan, make_twin, plan_of, walk_fast, walk_through_bytes
from sim_hw.realities.catalogue import find_reality, why_not_in
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import parse_effect
from sim_hw.twin.twin import Twin


def twin_file(request: SimRunRequest) -> ExitCode:
    """Walk, write, and say what was done.

    Raises:
        ConfigError: Options or effects that make no sense.
        ModelError: The robot stopped before it was done.
        RecordError: A file cannot be written.
    """
    begin_s = time.perf_counter()
    with ProgressBar("walking") as bar:
        trial = write_run(request, bar.show)
    wall_s = time.perf_counter() - begin_s
    forward_m = float(trial.body_position_m[-1, 0] - trial.body_position_m[0, 0])
    out, samples = request.out, len(trial.time_s)
    if request.json:
        print_json({"file": out, "samples": samples, "way_x_m": forward_m, "wall_s": wall_s})
    else:
        words = ", ".join(request.effect) if request.effect else "nothing wrong"
        print(f"{out}: {samples} samples of {trial.header.gait}, {words}")
        print(f"distance along x {forward_m:.3f} m; {request.seconds:g} s walked in {wall_s:.1f} s")
    return ExitCode.OK


def write_run(request: SimRunRequest, progress: Progress = silent) -> Trial:
    """Walk and write the file that is asked for; return the walk.

    Args:
        request: Which robot, what is wrong with it, how it walks, and the file.
        progress: Called with the share done, 0 to 1.

    Raises:
        ConfigError: Options or effects that make no sense.
        ModelError: The robot stopped before it was done.
        RecordError: A file cannot be written.
    """
    out = request.out
    if out.suffix not in {".parquet", ".csv", ".mcap"}:
        raise ConfigError("--out", f"must end in .parquet, .csv or .mcap, not {out}")
    if out.suffix == ".mcap" and request.fast:
        raise ConfigError("--fast", "gives trials, not logs; choose .parquet, or leave --fast out")
    if not out.parent.is_dir():
        raise ConfigError("--out", f"there is no folder {out.parent}; make it first")
    reality = find_reality(request.reality)
    config = robot_in(reality, load_robot(request.robot))
    effects = tuple(parse_effect(text, EFFECTS) for text in request.effect)
    for effect in effects:
        if why := why_not_in(reality, effect.name):
            raise ConfigError("--effect", f"{effect.name} cannot be in {reality.name}: {why}")
    twin = make_twin(config, effects, request.seed, reality)
    config, gait = with_gait(config, request.gait)
    plan = plan_of(config, gait, request.frequency_hz, request.seconds, request.steer)
    trial = _walk(config, twin, plan, request, progress)
    if out.suffix != ".mcap":
        write_trial(trial, out)
    return trial


def _walk(
    config: RobotConfig, twin: Twin, plan: WalkPlan, request: SimRunRequest, progress: Progress
) -> Trial:
    if request.fast:
        return walk_fast(config, twin, plan, progress)
    log = request.out if request.out.suffix == ".mcap" else None
    return walk_through_bytes(config, twin, plan, log, progress)
