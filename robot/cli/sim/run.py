"""``bigant sim run``: a walk of the virtual robot, with what is wrong with it, as a trial or a log.

The whole stack runs in virtual time: controller, servo bus and force unit, byte by byte. --fast leaves
the bytes out and gives the same trial in a fraction of the time. FILE.parquet and FILE.csv are trials
(the walk, with FILE.toml and the robot file beside it), FILE.mcap is a log of the whole run. The seed
also sets the day: friction, stiffness and centre of mass differ by a few per cent from seed to seed.
"""

import argparse
from pathlib import Path

from gaits.names import GAIT_NAMES
from robot.console.arguments import add_robot, positive, seed, steer
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--gait", choices=GAIT_NAMES, default="tripod")
    parser.add_argument(
        "--frequency-hz",
        type=positive,
        metavar="F",
        help="cycles a second (default: the robot file's)",
    )
    parser.add_argument(
        "--seconds", type=positive, default=30.0, metavar="S", help="of walking (default: 30)"
    )
    parser.add_argument(
        "--steer", type=steer, default=0.0, metavar="X", help="-1 (right) to 1 (left)"
    )
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="NAME[@LEG][:param=value,...]",
        help="what is wrong; may be given several times (bigant sim effects lists them)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help=".parquet, .csv or .mcap"
    )
    parser.add_argument("--fast", action="store_true", help="without the byte layer; no .mcap")
    parser.add_argument("--json", action="store_true", help="what was done as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Walk and write.

    Raises:
        ConfigError: Options or effects that make no sense.
        ModelError: The robot stopped before it was done.
        RecordError: A file cannot be written.
    """
    import json
    import time

    from model.errors import ConfigError
    from record.trial.trial import write_trial
    from record.whole_file import whole_file
    from robot.config.robot_file import load_robot
    from robot.console.progress import ProgressBar
    from robot.virtual.twin_log import twin_log
    from robot.virtual.twin_run import make_twin, plan_of, walk_fast
    from robot.virtual.twin_stack import walk_through_bytes
    from sim_hw.twin.catalog import EFFECTS
    from sim_hw.twin.effects import parse_effect

    out: Path = options.out
    if out.suffix not in {".parquet", ".csv", ".mcap"}:
        raise ConfigError("--out", f"must end in .parquet, .csv or .mcap, not {out}")
    if out.suffix == ".mcap" and options.fast:
        raise ConfigError("--fast", "gives trials, not logs; choose .parquet, or leave --fast out")
    if not out.parent.is_dir():
        raise ConfigError("--out", f"there is no folder {out.parent}; make it first")
    config = load_robot(options.robot)
    effects = tuple(parse_effect(text, EFFECTS) for text in options.effect)
    twin = make_twin(config, effects, options.seed)
    plan = plan_of(config, options.gait, options.frequency_hz, options.seconds, options.steer)
    begin_s = time.perf_counter()
    with ProgressBar("walking") as bar:
        if options.fast:
            trial = walk_fast(config, twin, plan, bar.show)
        elif out.suffix == ".mcap":
            with whole_file(out) as part:
                log = twin_log(part, config, plan)
                trial = walk_through_bytes(config, twin, plan, log, bar.show)
        else:
            trial = walk_through_bytes(config, twin, plan, None, bar.show)
    if out.suffix != ".mcap":
        write_trial(trial, out)
    wall_s = time.perf_counter() - begin_s
    way = float(trial.body_position_m[-1, 0] - trial.body_position_m[0, 0])
    if options.json:
        found = {"file": str(out), "samples": len(trial.time_s), "way_x_m": way, "wall_s": wall_s}
        print(json.dumps(found, indent=2))
    else:
        words = ", ".join(options.effect) if effects else "nothing wrong"
        print(f"{out}: {len(trial.time_s)} samples of {plan.gait}, {words}")
        print(f"way along x {way:.3f} m; {plan.seconds:g} s walked in {wall_s:.1f} s")
    return ExitCode.OK
