"""Bounds of effects grow with the robot, and every value that the search may try is accepted."""

from dataclasses import replace
from typing import Any

import pytest
import tomlkit

from gap.delegate import MachineOfEach
from gap.interfaces import Effect, check_causes
from gap.machine_kinds import kind_named, simulator_of
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.causes import Cause, Scope
from model.effects.machine import parse_machine
from model.effects.machine_scale import USUAL_SIZE, RobotSize, effects_for
from model.effects.settings import settings_of
from model.effects.written import table_name
from model.errors import GapError
from robot.config.robot_file import load_robot
from tests.gap.walks import machine, walk

SMALL = RobotSize(USUAL_SIZE.weight_n / 8.0, USUAL_SIZE.reach_m / 2.0)
LARGE = RobotSize(USUAL_SIZE.weight_n * 8.0, USUAL_SIZE.reach_m * 2.0)


def corners(effect: Effect) -> list[tuple[float, ...]]:
    """All numbers at their lower bound, at their upper one, and where nothing happens."""
    return [
        tuple(one.lower for one in effect.parameters),
        tuple(one.upper for one in effect.parameters),
        tuple(one.neutral for one in effect.parameters),
    ]


@pytest.mark.parametrize("size", [SMALL, USUAL_SIZE, LARGE], ids=["small", "usual", "large"])
def test_every_value_that_the_search_may_try_is_accepted(size: RobotSize) -> None:
    names = machine().names
    for effect in effects_for(size).values():
        places = names.legs[:1] if Scope.JOINT in effect.scopes else ()
        for values in corners(effect):
            settings_of([Cause(effect.name, places, values)], names, size)


def test_a_small_robots_stiction_is_of_its_own_speed() -> None:
    speed = effects_for(SMALL)["stiction"].parameters[-1]
    usual = effects_for(USUAL_SIZE)["stiction"].parameters[-1]
    assert (speed.lower, speed.upper) == (usual.lower / 2, usual.upper / 2)


def test_a_robot_file_may_hold_what_was_found_of_its_robot() -> None:
    stiction = f"\n[{table_name('stiction', ())}]\nstatic_ratio = 1.5\nspeed_m_s = 0.0015\n"
    with pytest.raises(GapError, match="speed_m_s must be from"):
        parse_machine(machine_text() + stiction)
    small = parse_machine(half_as_large(machine_text()) + stiction)
    assert small.effects == (Cause("stiction", (), (1.5, 0.0015)),)
    assert LeggedSimulator(small).effects == tuple(effects_for(small.size).values())


def test_numbers_of_a_common_cause_stay_within_the_bounds_of_each_robot() -> None:
    usual = walk("tripod", seconds=6.0)
    small = replace(
        usual,
        header=replace(usual.header, robot_text=half_as_large(machine_text()), robot_file="s.toml"),
    )
    both = simulator_of(kind_named("legged"), [usual, small])
    assert isinstance(both, MachineOfEach)
    assert {one.name for one in both.effects} == {one.name for one in simulator_of_one().effects}
    for effect in both.effects:
        places = both.joints[:1] if Scope.JOINT in effect.scopes else ()
        for values in corners(effect):
            for one in both.machines:
                check_causes([Cause(effect.name, places, values)], one)
    assert "other_machine" not in {fault.kind for fault in both.check(usual)}
    fault = both.check(small)[0]
    assert (fault.kind, fault.severe) == ("other_machine", True)
    assert (
        fault.evidence
        == "s.toml has a reach of 0.231 m, the file of the first trial one of 0.462 m"
    )


def simulator_of_one() -> LeggedSimulator:
    return LeggedSimulator(parse_machine(machine_text()))


def machine_text() -> str:
    return load_robot().text


def half_as_large(text: str) -> str:
    """A robot file with all lengths of legs and their places halved."""
    document = tomlkit.parse(text)
    leg: Any = document["leg"]
    for key in ("crank", "coupler", "rocker"):
        leg[key] = 0.5 * float(leg[key])
    for key in ("ground_pivot", "foot"):
        leg[key] = [0.5 * float(x) for x in leg[key]]
    legs: Any = document["legs"]
    legs["shaft_position"] = [[0.5 * float(x) for x in one] for one in legs["shaft_position"]]
    return tomlkit.dumps(document)
