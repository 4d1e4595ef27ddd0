"""Trials that are commanded as no reference was are said to be, whatever their length and direction."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.diagnosis.comparison.new_commands import new_commands, none_repeats
from gap.interfaces import Observation
from gap.residuals.command_cycle import PHASES, CommandCycle, command_cycle_of
from gap.residuals.parts import TrialPart, part_of
from record.trial.header import SERVO_BENCH, TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial
from tests.gap.walks import simulator, walk

HZ, RATE_HZ = 0.2, 100.0
NOISE = TrialNoise(float("nan"))


def commanded(
    turn: float, gait: str = "walk", seconds: float = 30.0, first_cycle: float = 0.0, hz: float = HZ,
) -> tuple[Trial, Observation]:  # fmt: skip
    """A shaft that turns once a cycle, unevenly, and one that does so by more with ``turn``."""
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    cycle = first_cycle + hz * time_s
    angle = 2 * np.pi * cycle
    header = TrialHeader(SERVO_BENCH, ("a", "b"), gait, abs(hz), RATE_HZ, "", NOISE, "", "")
    columns = (
        TableColumn("time_s", time_s),
        TableColumn("command_a_rad", angle + 0.3 * np.sin(angle)),
        TableColumn("command_b_rad", angle + (0.3 + turn) * np.sin(angle)),
        TableColumn("shaft_a_rad", angle),
        TableColumn("shaft_b_rad", angle),
    )
    values = np.zeros((len(time_s), 1))
    return build_trial(header, columns), Observation(
        time_s, cycle, values, values + 1.0, values + 1.0
    )


def part(index: int, *args: float, **more: float | str) -> TrialPart:
    trial, observation = commanded(*args, **more)  # type: ignore[arg-type]
    return part_of(index, trial, observation, 0, len(observation.time_s))


def cycle_of(*args: float, **more: float | str) -> CommandCycle:
    trial, observation = commanded(*args, **more)  # type: ignore[arg-type]
    made = command_cycle_of(trial, observation)
    assert made is not None
    return made


ALIKE = [part(k, 0.0) for k in range(4)]
STEERED = [part(k, turn) for k, turn in enumerate((-0.1, -0.05, 0.05, 0.1))]


def test_the_distance_is_the_root_mean_square_over_the_cycle() -> None:
    # 0.05 sin has a root mean square of 0.05 / sqrt(2); a chord is a hair shorter than its arc
    assert cycle_of(0.05).distance_rad(cycle_of(0.0)) == pytest.approx(0.05 / np.sqrt(2), rel=1e-3)
    assert cycle_of(0.0).distance_rad(cycle_of(0.0)) == 0.0


@pytest.mark.parametrize("gait", ["tripod", "metachronal"])
def test_legged_runs_are_commanded_alike_wherever_in_the_gait_they_begin(gait: str) -> None:
    parts = []
    for index, begin in enumerate((0, 130, 211, 470)):
        whole = walk(gait, seconds=20.0)
        trial = whole.rows(np.arange(len(whole.time_s)) >= begin)
        observation = simulator().observe(trial)
        parts.append(part_of(index, trial, observation, 0, len(observation.time_s)))
    assert not none_repeats(parts[:2])
    assert new_commands(parts[2:], parts[:2]) is None


def test_a_turn_is_new_where_all_references_walked_straight() -> None:
    found = new_commands([part(0, 0.0), part(1, 0.05)], ALIKE)
    assert found is not None
    assert found.trial == 1
    assert found.distance_rad == pytest.approx(0.05 / np.sqrt(2), rel=1e-3)
    assert found.known_rad == 0.0
    assert found.words.startswith("the commands of run 2 are")
    assert "references of its gait are commanded alike" in found.words


def test_a_turn_between_those_of_references_is_not_new_and_one_beyond_them_is() -> None:
    assert new_commands([part(0, 0.0), part(1, -0.12)], STEERED) is None
    found = new_commands([part(0, 0.3), part(1, 0.2)], STEERED)
    assert found is not None
    assert found.trial == 0
    assert found.known_rad == pytest.approx(0.05 / np.sqrt(2), rel=1e-2)
    assert found.trials == (0, 1)
    assert found.words.startswith("the commands of runs 1, 2 are up to")
    assert "references of its gait are within 0.035 rad of another one" in found.words


@given(
    st.floats(1.5, 12.0),
    st.floats(0.0, 1.0),
    st.sampled_from([HZ, -HZ, 0.13]),
    st.floats(-0.2, 0.2),
)
def test_a_part_of_the_same_walk_is_commanded_the_same(
    seconds: float, first_cycle: float, hz: float, turn: float
) -> None:
    one = cycle_of(turn, seconds=seconds, first_cycle=first_cycle, hz=hz)
    assert one.distance_rad(cycle_of(turn)) < 1e-4


def test_phases_that_a_short_run_did_not_reach_are_unknown() -> None:
    short = cycle_of(0.0, seconds=2.5)  # half a cycle
    known = np.isfinite(short.phasors).all(axis=1)
    assert known.sum() in (PHASES // 2, PHASES // 2 + 1)
    nowhere = cycle_of(0.0, seconds=0.02, first_cycle=0.01)  # two frames between two phases
    assert nowhere.distance_rad(cycle_of(0.5)) == 0.0


def test_runs_without_cycles_are_left_out() -> None:
    trial, seen = commanded(0.3)
    without = replace(seen, cycle=seen.cycle * np.nan)
    assert command_cycle_of(trial, without) is None
    assert new_commands([part_of(0, trial, without, 0, len(seen.time_s))], ALIKE) is None


def test_a_gait_that_no_reference_has_is_left_out() -> None:
    assert new_commands([part(0, 0.3, gait="trot")], ALIKE) is None
    assert new_commands([part(0, 0.3)], []) is None


def test_a_joint_without_commands_does_not_count() -> None:
    trial, observation = commanded(0.3)
    header, shaft = trial.header, trial.shaft_rad
    columns = [TableColumn("time_s", trial.time_s)]
    columns.append(TableColumn("command_a_rad", trial.command_rad[:, 0]))
    columns += [TableColumn(f"shaft_{j}_rad", shaft[:, k]) for k, j in enumerate("ab")]
    half = build_trial(header, tuple(columns))
    assert new_commands([part_of(0, half, observation, 0, 100)], ALIKE) is None


def test_references_that_all_differ_repeat_nothing() -> None:
    other_gait, faster = part(7, 0.0, gait="trot"), part(8, 0.0, hz=0.3)
    assert none_repeats(STEERED)
    assert none_repeats([*STEERED, part(6, 0.0), other_gait, faster])
    assert not none_repeats([*STEERED, part(9, 0.05, seconds=18.0)])
    assert not none_repeats(ALIKE)
    assert not none_repeats([])
