"""Virtual walks from a notebook: as ``bigant drive --virtual-time`` and ``bigant sim run`` make them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bigant.logs import Log, new_log
from record.trial.trial import Trial
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig, load_robot
from robot.run.operator import Script
from robot.virtual.twin_run import WalkPlan, make_twin, plan_of, walk_fast, walk_through_bytes
from robot.virtual.walk import record_walk
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import parse_effect
from sim_hw.twin.twin import Twin

NAME = "walk.mcap"  # of a log that is not saved


def walk(
    robot: RobotConfig | None = None,
    gait: str | None = None,
    *,
    cycles: float = 1.0,
    frequency_hz: float | None = None,
    steer: float = 0.0,
    seed: int = 0,
    effects: Sequence[str] | None = None,
) -> Log:
    """Let a virtual robot walk in virtual time, through the real drivers, and return its log.

    Args:
        robot: Robot file, read; the nominal BigANT if None.
        gait: A gait of the robot file, whose first it is if None; or a Python file of one (``my_gait.py``).
        cycles: Cycles of the gait.
        frequency_hz: Cycles a second; the robot file's if None.
        steer: -1 (right) to 1 (left).
        seed: Of plant and sensors; the same seed gives the same log.
        effects: What is made wrong with the robot, each as for ``bigant sim run --effect``, for example
            ``"leg_stiffness@MR:ratio=0.69"``. Such a robot differs from its file a little as well, as a
            real one does, and cameras see where it goes; with an empty list it is the healthy reference.
            None: the robot of the file itself, with ground truth, as ``bigant drive`` walks it.

    Returns:
        Log: in a temporary file; ``log.save("walk.mcap")`` keeps it.

    Raises:
        ConfigError: There is no such gait, or an effect does not fit the robot.
        GaitRefused: The servos cannot follow.
        ModelError: The robot stopped before it was done.
    """
    config = robot if robot is not None else load_robot()
    config, name = with_gait(config, gait)
    plan = _plan(config, name, cycles, frequency_hz, steer)
    if effects is None:
        script = Script(plan.gait, plan.frequency_hz, steer, cycles=cycles)
        return new_log(NAME, lambda path: record_walk(config, path, script, seed=seed))
    twin = _twin(config, effects, seed)

    def write(path: Path) -> None:
        walk_through_bytes(config, twin, plan, path)

    return new_log(NAME, write)


def walk_trial(
    robot: RobotConfig | None = None,
    gait: str | None = None,
    *,
    cycles: float = 1.0,
    frequency_hz: float | None = None,
    steer: float = 0.0,
    seed: int = 0,
    effects: Sequence[str] = (),
) -> Trial:
    """Walk as ``walk`` does with effects, without bytes and estimator: a trial in a fifth of the time.

    It is what ``bigant sim run --fast`` writes, and what ``diagnose`` takes beside logs. Arguments and
    errors are those of ``walk``.
    """
    config = robot if robot is not None else load_robot()
    config, name = with_gait(config, gait)
    plan = _plan(config, name, cycles, frequency_hz, steer)
    return walk_fast(config, _twin(config, effects, seed), plan)


def _plan(
    config: RobotConfig, gait: str, cycles: float, frequency_hz: float | None, steer: float
) -> WalkPlan:
    plan = plan_of(config, gait, frequency_hz, 0.0, steer)
    return replace(plan, seconds=cycles / plan.frequency_hz)


def _twin(config: RobotConfig, effects: Sequence[str], seed: int) -> Twin:
    texts = (effects,) if isinstance(effects, str) else effects
    return make_twin(config, tuple(parse_effect(text, EFFECTS) for text in texts), seed)
