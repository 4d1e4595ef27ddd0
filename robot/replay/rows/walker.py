"""The controller over a block of recorded ticks: those of a walk in which nothing happens at once.

A loop cannot know the next ticks; a replay does. While a robot walks on, and no watch and no limit has
anything to say, what the step computes of a tick depends on little of the tick before. Then many are
computed at once; the first in which anything happens is left to the step.
"""

from math import exp

import numpy as np

from drivers.dynamixel.joints import joint_rows
from gaits.plan import GoalRows, Walking
from model.kinematics.one_shaft import OneShaftKinematics
from model.motion.dead_reckoning import advance_rows
from model.motion.differentiate import latest_rates
from model.quasistatic.frame import solve_rows
from model.values.arrays import BoolArray, FloatArray, part_of, readonly
from model.values.faults import StopReason
from model.values.gravity import STANDARD_GRAVITY
from model.values.input_rows import InputRows
from model.values.legs import JointCommand
from model.values.tick import Mode
from model.values.tick_rows import JointRows
from robot.control.controller import Controller
from robot.control.modes import Phase
from robot.control.state import ControllerState
from robot.replay.rows.travels import travelled
from robot.replay.rows.usual import (
    Commands,
    body_well,
    goes_on,
    leading,
    passes,
    sensed_by_all,
    servos_well,
    walks_on,
)
from robot.replay.rows.walked import Ending, WalkedRows, WalkRows

FEWEST = 8  # ticks: fewer take longer so


def row_walker(controller: Controller) -> "RowWalker | None":
    """Return what steps a controller in rows.

    Returns:
        None where an estimator or effects are part of its steps, or a joint is not the shaft of one leg.
    """
    kinematics = controller.kinematics
    if not (controller.bare and isinstance(kinematics, OneShaftKinematics)):
        return None
    return RowWalker(controller, kinematics)


class RowWalker:
    """A controller that has neither an estimator nor effects, of a robot whose legs turn on one shaft each.

    Args:
        controller: The controller.
        kinematics: Its shafts to feet.
    """

    def __init__(self, controller: Controller, kinematics: OneShaftKinematics) -> None:
        self._config, self._kinematics = controller.config, kinematics
        self._scales, self._book = controller.scales, controller.book
        self._period_ns = controller.period_ns
        self._weight_n = self._config.parameters.body.mass * STANDARD_GRAVITY
        self._every_foot = sensed_by_all(self._config)
        # how many ticks are tried: where something happens often, little is computed in vain
        self._most = 2 * FEWEST

    def advance(self, state: ControllerState, inputs: InputRows, begin: int) -> WalkedRows | None:
        """Advance by ticks of a block, from one on, up to the first in which anything happens.

        Args:
            state: State before it.
            inputs: Inputs of the block.
            begin: Which tick.

        Returns:
            None where that are too few.
        """
        plan = state.decision.phase.plan
        if not walks_on(state, self._book) or not isinstance(plan, Walking):
            return None
        usual = goes_on(inputs, plan, self._config.loop.late_limit_s, self._period_ns)[begin:]
        usual &= inputs.index[begin:] == state.index + np.arange(len(usual))
        count = tried = min(leading(usual), self._most)
        if count < FEWEST:
            return None
        span = slice(begin, begin + count)
        rows, commands, well = self._computed(state, inputs, span, plan)
        joints, limits = rows.joints, self._config.body_limits
        dt_s = np.maximum(0.0, np.diff(joints.t_ns, prepend=state.decision.body.t_ns) * 1e-9)
        fade = np.array([exp(-dt / limits.stall_time) for dt in dt_s.tolist()])
        count = leading(well)
        count, travels = travelled(
            state.decision.body.travels, commands.before_rad[:count],
            (joints.angle_rad[:count], joints.current_a[:count]), fade[:count], limits,
        )  # fmt: skip
        self._most = 2 * (tried if count == tried else max(count, FEWEST))
        if count < FEWEST:
            return None
        phase = Phase(Mode.WALK, plan, self._book.gaits[plan.gait.name], StopReason.NONE)
        last = self._last(state, commands, count - 1)
        window = len(state.senses.times_ns)
        times_ns = np.concatenate([state.senses.times_ns, joints.t_ns[:count]])[-window:]
        angles_rad = np.concatenate([state.senses.angles_rad, joints.angle_rad[:count]])[-window:]
        ending = Ending(phase, last, times_ns, angles_rad, travels)
        return WalkedRows(state, inputs, begin, part_of(rows, slice(count)), ending)

    def _computed(
        self, state: ControllerState, inputs: InputRows, span: slice, plan: Walking
    ) -> tuple[WalkRows, Commands, BoolArray]:
        """Outputs of ticks, their commands, and in which of them nothing happens."""
        config, t_ns, servos = self._config, inputs.t_ns[span], part_of(inputs.servos, span)
        joints = joint_rows(servos, config.servo_bus)
        records = part_of(inputs.records, span)
        forces = self._scales.rows(records, joints.angle_rad, state.senses.forces)
        silent_ns = config.force_sensor.silent_limit_s * 1e9
        heard = records.there | (t_ns - forces.t_ns <= silent_ns) | (forces.t_ns < 0)
        feet = self._kinematics.feet(joints.angle_rad, self._rates(state, joints))
        contact = solve_rows(feet, config.parameters.contact, self._weight_n)
        before = state.estimates.dead_reckoning
        position_m, yaw_rad = advance_rows(before, contact.parts[0], t_ns)
        goals = plan.rows(t_ns.tolist())
        rows = WalkRows(t_ns, joints, forces, feet, contact, position_m, yaw_rad, goals)
        commands = self._commands(state, inputs, span, goals)
        well = (
            heard
            & servos_well(servos, joints, commands.before_rad, config.limits)
            & body_well(
                contact, forces if self._every_foot else None,
                np.vstack([before.position_m, position_m[:-1]]), self._weight_n,
                config.body_limits,
            )
            & passes(commands, config.limits, config.servo_bus)
        )  # fmt: skip
        return rows, commands, well

    def _rates(self, state: ControllerState, joints: JointRows) -> FloatArray:
        """Speeds of the shafts from their latest angles, (T, N)."""
        senses, window = state.senses, len(state.senses.times_ns)
        times_ns = np.concatenate([senses.times_ns[1:], joints.t_ns])
        angles_rad = np.concatenate([senses.angles_rad[1:], joints.angle_rad])
        return latest_rates(times_ns, angles_rad, window)

    def _commands(
        self, state: ControllerState, inputs: InputRows, span: slice, goals: GoalRows
    ) -> Commands:
        """Commands, with the one before each dated when the bus was done with it."""
        last, timing = state.allowed.command, inputs.timing
        t_ns = inputs.t_ns[span]
        before_ns = np.concatenate([[last.t_ns], t_ns[:-1]])
        done_ns = timing.deadline_ns[span] - (1 + timing.missed[span]) * self._period_ns
        before_rad = np.vstack([last.angle_rad, goals.angle_rad[:-1]])
        return Commands(
            t_ns, goals.angle_rad, goals.rate_rad_s, np.maximum(before_ns, done_ns), before_rad
        )

    def _last(self, state: ControllerState, commands: Commands, k: int) -> JointCommand:
        """The command before tick k, with its date."""
        rate = state.allowed.command.rate_rad_s if k == 0 else commands.rate_rad_s[k - 1]
        return JointCommand(
            int(commands.before_ns[k]), readonly(commands.before_rad[k]), rate, torque=True
        )
