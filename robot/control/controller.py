"""The controller: one pure step from the inputs of a tick to its outputs.

No clock, bus, file or logger. The loop, virtual walks and replays call this same function. Its blocks are
*sense* (counts to angles and forces), *estimate* (model and pose), *decide* (watches, stops, recovery,
mode) and *command* (plan and safety gate); what they hand on is in ``robot.control.state``.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.ati import foot_forces
from drivers.ati.calibration import Calibration
from drivers.ati.foot_forces import ForceScales, no_forces
from drivers.dynamixel.joints import ReadCalibration
from gaits import buehler
from gaits.catalog import make_gaits
from gaits.gait import Gait
from gaits.plan import Walking
from model.kinematics.legs import leg_kinematics
from model.motion import differentiate
from model.motion.dead_reckoning import advance as advance_dead_reckoning
from model.quasistatic.frame import prepare, solve_frame
from model.values.arrays import readonly
from model.values.contact import ContactSolution, no_contact
from model.values.faults import Fault, FaultKind, StopReason
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootForces, FootMotion, JointCommand, JointState, no_feet
from model.values.readings import silent_readings
from model.values.tick import DeadReckoning, Inputs, Mode, Tick
from robot.config.robot_file import RobotConfig
from robot.config.undriven import not_driven
from robot.control.body_watch import BodyInputs, BodyMemory, watch_body
from robot.control.effects import model_of
from robot.control.estimator_stage import EstimatorStage, estimator_stage
from robot.control.modes import GaitBook, Phase, Situation, advance
from robot.control.recovery import (
    RecoveryInputs,
    RecoveryMemory,
    RecoveryPlan,
    legs_down,
    plan_recovery,
)
from robot.control.safety import (
    Allowed,
    Refused,
    ServoVerdict,
    gate,
    watch_servos,
    watch_timing,
    watch_turns,
)
from robot.control.state import Command, ControllerState, Decision, Estimates, Senses
from robot.control.stops import gravest, stop_at_once

# Shaft speed is the slope over this many seconds of encoder readings.
RATE_WINDOW_S = 0.1
# Refused commands in a row before the robot halts.
REFUSED_LIMIT = 5
NOT_RUN = "the model was not run"


class Controller:
    """The step and what it needs to know beforehand.

    Nothing that a tick calls can compile: it is done here, where nothing waits for it.

    Args:
        config: Robot file.
        calibrations: Calibration of each leg's transducer, None where there is none.
        armed: Whether torque may be asked for.
        rate_hz: Rate of the loop, or None for the robot file's.
        gaits: Gaits it can walk, or None for the robot file's.
        estimate: Whether to run the estimator, if the robot file wants it. A campaign's walks go without:
            no limit and no command depends on it. The model and dead reckoning run in any case, as limits
            on tilt, slip and distance need them.
    """

    def __init__(
        self,
        config: RobotConfig,
        calibrations: tuple[Calibration | None, ...],
        *,
        armed: bool,
        rate_hz: int | None = None,
        gaits: Sequence[Gait] | None = None,
        estimate: bool = True,
    ) -> None:
        if not config.driven:
            raise not_driven(config.parameters.leg)
        self.config = config
        self.armed = armed
        self.rate_hz = rate_hz if rate_hz is not None else config.loop.rate_hz
        self.period_ns = round(1e9 / self.rate_hz)
        robot = config.parameters
        if gaits is None:
            gaits = make_gaits(robot)
        self.book = GaitBook.of(gaits, robot.servo)
        self._calibration = ReadCalibration(config.servo_bus)
        self.scales = ForceScales(calibrations, config.force_sensor)
        self._no_forces = no_forces(robot.legs.count)
        self._weight_n = robot.body.mass * STANDARD_GRAVITY
        self._sensors = tuple(number > 0 for number in config.force_sensor.transducers.tolist())
        self._nothing = readonly(np.full(robot.legs.count, np.nan))
        self._effects = model_of(config)
        self.kinematics = leg_kinematics(robot)
        self._estimator: EstimatorStage | None = None
        if config.estimator.enabled and estimate:
            self._estimator = estimator_stage(config, self.kinematics)
        prepare()
        differentiate.prepare()
        buehler.prepare()
        foot_forces.prepare()
        self.kinematics.prepare()

    @property
    def bare(self) -> bool:
        """Whether a step has neither an estimator nor effects of the robot file."""
        return self._effects is None and self._estimator is None

    def initial(self) -> ControllerState:
        """Return the state before the first tick."""
        count = self.config.parameters.legs.count
        window = max(3, round(RATE_WINDOW_S * self.rate_hz) + 1)
        silent = silent_readings(0, count)
        command = JointCommand(0, self._nothing, self._nothing, torque=False)
        senses = Senses(
            servos=silent,
            joints=self._calibration.state(silent),
            forces=self._no_forces,
            down=silent.valid,
            last=command,
            times_ns=np.zeros(window, dtype=np.int64),
            angles_rad=np.full((window, count), np.nan),
            began_ns=-1,
        )
        estimates = Estimates(
            feet=no_feet(count),
            contact=no_contact(count, NOT_RUN),
            forces=self._no_forces,
            dead_reckoning=DeadReckoning(0, np.zeros(2), 0.0, np.full(3, np.nan), valid=False),
            estimate=None,
            estimator=self._estimator.initial() if self._estimator is not None else None,
            faults=(),
        )
        decision = Decision(
            phase=Phase(Mode.IDLE, None, None, StopReason.NONE),
            recovery=RecoveryPlan(RecoveryMemory.empty(count)),
            servos=ServoVerdict.sound(count),
            body=BodyMemory.empty(count),
            late=0,
            faults=(),
        )
        return ControllerState(
            0, senses, estimates, decision, Command(command, Allowed(command), 0, ())
        )

    def step(
        self, state: ControllerState, inputs: Inputs, t_ns: int
    ) -> tuple[ControllerState, Tick]:
        """Advance by one tick.

        Args:
            state: State after the tick before.
            inputs: Everything known in this tick.
            t_ns: Time of the tick.

        Returns:
            The new state and the tick, which holds the inputs, every stage's output and the faults.
        """
        senses = self._sense(state, inputs, t_ns)
        estimates = self._estimate(state, inputs, senses, t_ns)
        decision = self._decide(state, inputs, senses, estimates, t_ns)
        phase = decision.phase
        command = self._command(state, senses, decision, t_ns)
        gait_phase = phase.plan.phase(t_ns) if isinstance(phase.plan, Walking) else np.nan
        tick = Tick(
            t_ns=t_ns,
            index=state.index,
            mode=phase.mode,
            stop_reason=phase.stop_reason,
            inputs=inputs,
            joints=senses.joints,
            forces=senses.forces,
            gait_phase=gait_phase,
            wished=command.wished,
            sent=command.allowed.command,
            feet=estimates.feet,
            contact=estimates.contact,
            dead_reckoning=estimates.dead_reckoning,
            faults=(*inputs.faults, *decision.faults, *command.faults, *estimates.faults),
            estimate=estimates.estimate,
        )
        return ControllerState(state.index + 1, senses, estimates, decision, command), tick

    # Sense.

    def _sense(self, state: ControllerState, inputs: Inputs, t_ns: int) -> Senses:
        """Turn counts into angles and forces; what is missing or implausible is NaN."""
        servos = inputs.servos
        if servos is None:
            servos = silent_readings(t_ns, self.config.parameters.legs.count)
        down, usable = legs_down(state.decision.recovery.memory, inputs.servo_events), servos
        began_ns = t_ns if state.index == 0 else state.senses.began_ns
        if True in down.tolist():
            # after a restart a servo has another number for the same angle
            usable = replace(servos, valid=readonly(servos.valid & ~down))
        joints = self._calibration.state(usable)
        before, forces = state.senses, self._newest_forces(state, inputs, t_ns, joints)
        times_ns, angles_rad = np.empty_like(before.times_ns), np.empty_like(before.angles_rad)
        times_ns[:-1], angles_rad[:-1] = before.times_ns[1:], before.angles_rad[1:]
        times_ns[-1] = t_ns if state.index == 0 else joints.t_ns
        angles_rad[-1] = joints.angle_rad
        last = self._last_command(state, inputs)
        return Senses(servos, joints, forces, down, last, times_ns, angles_rad, began_ns)

    def _newest_forces(
        self, state: ControllerState, inputs: Inputs, t_ns: int, joints: JointState
    ) -> FootForces:
        """Return the forces of the newest record, absent after too long a silence."""
        forces = state.senses.forces
        if inputs.forces:
            return self.scales.forces(inputs.forces[-1], joints.angle_rad)
        if t_ns - forces.t_ns > self.config.force_sensor.silent_limit_s * 1e9:
            return self._no_forces
        return forces

    def _last_command(self, state: ControllerState, inputs: Inputs) -> JointCommand:
        """Return the last command, dated when the bus was done with it.

        Switching torque on, or bringing a servo back, takes a dozen transactions. The loop begins a new
        grid of deadlines behind them (``robot.run.loop.run``), so the deadline says when they were done.
        """
        last, timing = state.allowed.command, inputs.timing
        done_ns = timing.deadline_ns - (1 + timing.missed) * self.period_ns
        if not last.torque or done_ns <= last.t_ns:
            return last
        return replace(last, t_ns=done_ns)

    # Estimate.

    def _estimate(
        self,
        state: ControllerState,
        inputs: Inputs,
        senses: Senses,
        t_ns: int,
    ) -> Estimates:
        """Solve the model for the measured shafts, and estimate where the body is."""
        forces = senses.forces
        if self._effects is not None:
            forces = self._effects.true_forces(forces, (t_ns - senses.began_ns) * 1e-9)
        feet, contact = self._model(state, senses, t_ns)
        faults: tuple[Fault, ...] = ()
        if not contact.support.converged:
            faults = (Fault(FaultKind.NO_SUPPORT, "support", contact.support.reason),)
        before = state.estimates.dead_reckoning
        if state.index == 0:
            before = replace(before, t_ns=t_ns)
        dead_reckoning = advance_dead_reckoning(before, contact.traction.velocity_B, t_ns)
        memory, estimate = state.estimates.estimator, None
        if self._estimator is not None and memory is not None:
            memory, estimate = self._estimator.step(
                memory, t_ns, senses.joints, senses.forces, inputs.poses, inputs.imu
            )
        return Estimates(feet, contact, forces, dead_reckoning, estimate, memory, faults)

    def _model(
        self, state: ControllerState, senses: Senses, t_ns: int
    ) -> tuple[FootMotion, ContactSolution]:
        """Feet, support and traction, with what the robot file adds to the nominal model."""
        angle_rad = senses.joints.angle_rad
        rate_rad_s = differentiate.latest_rate(senses.times_ns, senses.angles_rad)
        if self._effects is None:
            feet = self.kinematics.feet(angle_rad, rate_rad_s)
            return feet, solve_frame(feet, self.config.parameters.contact, self._weight_n)
        before = state.estimates.dead_reckoning
        dt_s = 0.0 if state.index == 0 else (t_ns - before.t_ns) * 1e-9
        pose = np.array([*before.position_m, before.yaw_rad])
        frame = self._effects.solve(angle_rad, rate_rad_s, pose, before.velocity_B, dt_s)
        return frame.feet, frame.contact

    # Decide.

    def _decide(
        self,
        state: ControllerState,
        inputs: Inputs,
        senses: Senses,
        estimates: Estimates,
        t_ns: int,
    ) -> Decision:
        """Compare everything with its limits; decide on stops, on recovery and on the next mode."""
        config, names = self.config, self.config.servo_bus.names
        before, sent, joints = state.decision, state.allowed.command, senses.joints
        servos = watch_servos(
            senses.servos, joints, sent, before.servos, config.limits, config.servo_bus
        )
        turn_faults = watch_turns(senses.servos, sent, names)
        late, timing_faults = watch_timing(
            inputs.timing, before.late, self.period_ns, config.loop.late_limit_s
        )
        shown = BodyInputs(
            t_ns=joints.t_ns,
            mode=before.phase.mode,
            joints=joints,
            sent=sent,
            forces=estimates.forces,
            contact=estimates.contact,
            dead_reckoning=state.estimates.dead_reckoning,
            weight_n=self._weight_n,
            sensors=self._sensors,
            down=senses.down,
        )
        body, body_faults = watch_body(before.body, shown, config.body_limits, names)
        asked = RecoveryInputs(
            t_ns=t_ns,
            events=inputs.servo_events,
            verdict=servos,
            valid=senses.servos.valid,
            age_ns=senses.servos.age_ns,
            holding=before.phase.mode is Mode.HOLD,
            torque=sent.torque,
        )
        recovery = plan_recovery(before.recovery.memory, asked, config.recovery, names)
        stop = gravest(
            stop_at_once(inputs.faults),
            self._loop_stop(state, senses.last, late, t_ns),
            recovery.stop,
            stop_at_once(body_faults),
            stop_at_once(turn_faults),
        )
        situation = Situation(
            t_ns, inputs.request, stop, joints.angle_rad, self.armed, recovery.pause,
            recovery.resume,
        )  # fmt: skip
        phase = advance(before.phase, situation, self.book)
        faults = (*servos.faults, *turn_faults, *timing_faults, *body_faults, *recovery.faults)
        return Decision(phase, recovery, servos, body, late, faults)

    def _loop_stop(
        self, state: ControllerState, last: JointCommand, late: int, t_ns: int
    ) -> StopReason:
        """Return the stop that comes from the loop itself: refused commands, or too late too often."""
        if state.command.refused >= REFUSED_LIMIT:
            return StopReason.COMMAND_REFUSED
        waited = (
            state.command.refused or state.allowed.recover
        )  # bringing a servo back takes its time
        silent_s = (t_ns - last.t_ns) * 1e-9 if last.torque and not waited else 0.0
        if late >= self.config.loop.late_ticks or silent_s >= self.config.servo_bus.watchdog_s:
            return StopReason.TIMING
        return StopReason.NONE

    # Command.

    def _command(
        self, state: ControllerState, senses: Senses, decision: Decision, t_ns: int
    ) -> Command:
        """Ask the plan for the next goals, and the safety gate about them."""
        plan, recovery = decision.phase.plan, decision.recovery
        wished = JointCommand(t_ns, self._nothing, self._nothing, torque=False)
        if plan is not None:
            angle, rate = plan.at(t_ns)
            wished = JointCommand(t_ns, readonly(angle), readonly(rate), torque=True)
        last = senses.last
        # switching on, or taking a servo up again: the driver holds where the shafts are
        begins = not last.torque or recovery.resume is not None or bool(state.allowed.recover)
        if wished.torque and begins:
            last = replace(wished, torque=False)
        refused_ns = state.command.wished.t_ns if state.command.refused and not begins else None
        verdict = gate(
            wished, last, self.config.limits, self.config.servo_bus, recovery.ask, refused_ns
        )
        if isinstance(verdict, Refused):
            fault = Fault(FaultKind.REFUSED, "safety gate", verdict.reason)
            return Command(
                wished, Allowed(state.allowed.command), state.command.refused + 1, (fault,)
            )
        return Command(wished, verdict, 0, ())
