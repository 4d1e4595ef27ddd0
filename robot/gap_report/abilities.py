"""What an imported run can be used for, and for what not and why."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gap.coverage.coverage import Coverage, coverage_of
from gap.interfaces import Simulator
from model.errors import BigantError, ConfigError
from model.values.arrays import FloatArray
from record.trial.header import LEGGED
from record.trial.trial import Trial
from robot.config.robot_file import parse_robot
from robot.gap_report.blind import FOOT_MARKERS, FORCE_SENSORS, JOINT_ANGLES, POSE, sensor_of
from robot.gap_report.trials import simulator_for

FEET, FORCES = "feet (markers)", "forces"
KINDS = {JOINT_ANGLES: "shafts", FOOT_MARKERS: FEET, FORCE_SENSORS: FORCES, POSE: "body"}
NO_ROBOT = 'no robot file; add robot = "FILE.toml" to [trial] in the map or beside the table'


class Ability(NamedTuple):
    """Something that may be asked of a run, such as odometry; whether it can, and words on it."""

    question: str
    answered: bool
    words: str


def abilities(trial: Trial) -> tuple[Ability, ...]:
    """Return what a trial can be used for, by what each command needs."""
    return (
        *(
            (odometry_ability(trial), _truth(trial), _forces(trial))
            if trial.header.kind == LEGGED
            else ()
        ),
        _diagnosis(trial),
    )


def _known(values: FloatArray) -> list[bool]:
    """Whether anything is known of each of the last columns, (T, ..., C)."""
    return [bool(np.isfinite(column).any()) for column in values.T]


def odometry_ability(trial: Trial) -> Ability:
    """Say whether the estimator can run over a trial."""
    known = _known(trial.shaft_rad + trial.shaft_rad_s)
    lacking = [name for name, one in zip(trial.joints, known, strict=True) if not one]
    if not trial.header.robot_text:
        return Ability("odometry", False, NO_ROBOT)
    if len(lacking) == len(trial.joints):
        return Ability("odometry", False, "no shaft angles (shaft_J_rad)")
    try:
        names = parse_robot(trial.header.robot_text).parameters.names
    except ConfigError as error:
        return Ability("odometry", False, f"the robot file cannot be used: {error}")
    if names != trial.header.names:
        words = f"the robot file has {len(names.legs)} legs and {len(names.joints)} joints by other names"
        return Ability("odometry", False, words)
    if lacking:
        words = f"worse without shaft angles of {', '.join(lacking)}"
        return Ability("odometry", True, words)
    derived = "; speeds are computed from angles" if trial.header.derived else ""
    return Ability(
        "odometry", True, f"shaft angles and speeds of all {len(trial.joints)} joints{derived}"
    )


def _truth(trial: Trial) -> Ability:
    place, angles = _known(trial.body_position_m), _known(trial.body_angles_rad)
    if not all(place[:2]):
        return Ability("ground truth", False, "no positions of the body (body_x_m, body_y_m)")
    if all(angles):
        return Ability("ground truth", True, "positions and attitudes of the body")
    if angles[2]:
        return Ability(
            "ground truth", True, "positions and headings of the body, no roll and pitch"
        )
    words = "positions of the body without an attitude: no relative errors, no velocities"
    return Ability("ground truth", True, words)


def _forces(trial: Trial) -> Ability:
    legs, axes = _known(np.moveaxis(trial.force_n, 2, 1)), _known(trial.force_n)
    having = [name for name, one in zip(trial.legs, legs, strict=True) if one]
    if not having:
        return Ability("forces", False, "no sensors (force_J_x_n and so on)")
    lacking = [axis for axis, one in zip("xyz", axes, strict=True) if not one]
    without = f", without {' and '.join(lacking)}" if lacking else ""
    return Ability("forces", True, f"of {', '.join(having)}{without}")


def _diagnosis(trial: Trial) -> Ability:
    if not trial.header.robot_text:
        return Ability("diagnosis", False, NO_ROBOT)
    try:
        coverage = coverage_of(run_simulator(trial), trial)
    except BigantError as error:
        return Ability("diagnosis", False, str(error))
    total = len(coverage.visible) + len(coverage.hidden)
    if not coverage.measured:
        return Ability("diagnosis", False, "nothing was measured that the simulator predicts")
    words = (
        f"{len(coverage.visible)} of {total} effects visible, in {_groups(coverage, measured=True)}"
    )
    missing = _groups(coverage, measured=False)
    if missing:
        words += f"; not measured: {missing}"
    if kept := ", ".join(_not_compared(trial, coverage)):
        words += f"; kept, but not compared, as the simulator does not predict them: {kept}"
    if coverage.hidden:
        words += f"; not visible: {', '.join(coverage.hidden)}"
    return Ability("diagnosis", True, words)


def _not_compared(trial: Trial, coverage: Coverage) -> list[str]:
    """Kinds of channels of legs that were measured, and that the simulator has no channels for."""
    measured = (one.name for one in coverage.measured)
    predicted = {_kind(name) for name in (*measured, *coverage.missing)}
    legs = ((FEET, trial.foot_m), (FORCES, trial.force_n))
    return [kind for kind, one in legs if kind not in predicted and np.isfinite(one).any()]


def _groups(coverage: Coverage, *, measured: bool) -> str:
    """Kinds of channels in a few words: shafts, feet, forces, body."""
    have = dict.fromkeys(_kind(channel.name) for channel in coverage.measured)
    # of a kind that is measured at some places, the rest needs no mention
    lacking = dict.fromkeys(kind for name in coverage.missing if (kind := _kind(name)) not in have)
    return ", ".join(have if measured else lacking)


def _kind(channel: str) -> str:
    """Words for where a channel is read."""
    sensor = sensor_of(channel)
    return KINDS.get(sensor, sensor)


@lru_cache(maxsize=1)
def run_simulator(trial: Trial) -> Simulator:
    """Return the simulator of a trial; what is read of a MuJoCo model follows from what was logged.

    Raises:
        GapError: The machine's file cannot be used.
    """
    return simulator_for([trial])


def ability_rows(each: Sequence[Ability]) -> list[tuple[str, str]]:
    """Return label and words of each row of a report."""
    return [(one.question, f"{'yes' if one.answered else 'no'}: {one.words}") for one in each]
