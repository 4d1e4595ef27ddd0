"""The chain of effects on cranks: what a rolling leg's feet do, and that the controller's frame agrees."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.machines.legged.simulator import LeggedSimulator
from model.effects.causes import Cause
from model.effects.frame import FrameModel
from model.effects.grid import Grid
from model.effects.machine import LeggedMachine, parse_machine
from model.effects.machine_scale import USUAL_SIZE
from model.effects.settings import settings_of
from model.effects.shafts import feet, load_torque
from model.errors import GapError
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frame import solve_frame
from model.values.parameters import CrankParameters
from robot.config.robot_file import load_robot

WHEEL = Path(__file__).resolve().parents[2] / "examples" / "wheel_hexapod.toml"
CONFIG = load_robot(WHEEL)
MACHINE = parse_machine(CONFIG.text)
LEGS = MACHINE.names
NEUTRAL = settings_of((), LEGS, USUAL_SIZE)
STRAIGHT = replace(MACHINE, leg=CrankParameters(0.09, 0.0))


def swept(frames: int = 301, period_s: float = 0.002) -> tuple[Grid, np.ndarray, np.ndarray]:
    """A grid, shafts turning through stance at their own speeds, and those speeds."""
    grid = Grid(0.0, period_s, frames, period_s)
    rate = np.array([0.9, 1.1, 0.7, 1.3, 0.8, 1.0])
    start = np.array([-0.5, -0.6, -0.4, 0.1, -0.1, 0.2])
    return grid, start + rate * grid.time_s[:, None], np.broadcast_to(rate, (frames, 6))


@pytest.mark.parametrize("machine", [MACHINE, STRAIGHT], ids=["round", "straight"])
def test_feet_of_the_chain_move_as_the_kinematics_say(machine: LeggedMachine) -> None:
    grid, angle, rate = swept()
    exact = leg_kinematics(machine).feet(angle, rate)
    walked = feet(machine, grid, angle, NEUTRAL)
    np.testing.assert_allclose(walked.signals.position_m, exact.position_m, atol=1e-15)
    # a slope over a window, of a path whose curvature changes where the half circle ends
    inner = slice(40, -40)
    np.testing.assert_allclose(walked.rate_m_s[inner], exact.velocity_m_s[inner], atol=4e-4)


@pytest.mark.parametrize("machine", [MACHINE, STRAIGHT], ids=["round", "straight"])
def test_the_torque_of_a_load_is_that_of_its_lever_about_the_shaft(machine: LeggedMachine) -> None:
    grid, angle, _ = swept()
    walked = feet(machine, grid, angle, NEUTRAL)
    force = np.random.default_rng(2).normal(0.0, 5.0, (*angle.shape, 3))
    arm = walked.signals.position_m - machine.legs.shaft_position
    # the torque that drives the shaft on is against +y: a growing angle takes -z towards -x
    about_y = np.cross(arm, force)[..., 1]
    np.testing.assert_allclose(load_torque(walked.signals, force), about_y, atol=1e-12)


@pytest.mark.parametrize("machine", [MACHINE, STRAIGHT], ids=["round", "straight"])
def test_a_frame_with_effects_is_the_frame_without_where_they_do_nothing(
    machine: LeggedMachine,
) -> None:
    nothing = replace(machine, effects=(Cause("foot_friction", ("ML",), (1.0,)),))
    model = FrameModel(nothing)
    kinematics = leg_kinematics(machine)
    angle = np.array([-0.3, 0.05, -0.31, 0.02, -0.29, 0.04])
    rate = np.array([0.8, 0.9, 0.85, 0.7, 0.95, 0.75])
    answer = model.solve(angle, rate, np.zeros(3), np.full(3, np.nan), 0.0)
    plain = kinematics.feet(angle, rate)
    contact = solve_frame(plain, machine.contact, machine.size.weight_n)
    np.testing.assert_allclose(answer.feet.position_m, plain.position_m, atol=1e-12)
    np.testing.assert_allclose(answer.feet.velocity_m_s, plain.velocity_m_s, atol=1e-6)
    np.testing.assert_allclose(
        answer.contact.traction.velocity_B, contact.traction.velocity_B, atol=1e-6
    )


def test_a_ball_on_a_straight_legs_toe_rolls_like_a_half_circle() -> None:
    """A straight leg of L - r with a ball of radius r below: its centre is that of a C-leg of L and r."""
    grid, _, _ = swept()
    angle = np.tile(-0.6 + 0.9 * grid.time_s[:, None], (1, 6))  # the half circle's part of a stance
    assert isinstance(MACHINE.leg, CrankParameters)
    length, radius = MACHINE.leg.length, MACHINE.leg.radius
    ball = replace(MACHINE, leg=CrankParameters(length - radius, 0.0))
    rolling = settings_of((Cause("foot_rolling", (), (radius,)),), LEGS, USUAL_SIZE)
    as_ball, as_leg = feet(ball, grid, angle, rolling), feet(MACHINE, grid, angle, NEUTRAL)
    turned = as_ball.rate_m_s[..., 0] + radius * grid.slope(as_ball.turn_rad, 0.13)
    np.testing.assert_allclose(turned, as_leg.rate_m_s[..., 0], atol=1e-12)


def test_a_cause_that_cranks_cannot_have_is_refused() -> None:
    simulator = LeggedSimulator(MACHINE)
    with pytest.raises(GapError, match="cannot have link_length: a crank has no links"):
        simulator._settings((Cause("link_length", (), (0.001, 0.0, 0.0)),))
