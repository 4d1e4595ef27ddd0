"""The controller: one pure step from the inputs of a tick to its outputs.

No clock, bus, file or logger. The loop, the replay and the diagnosis call this same function.
"""

from dataclasses import replace

import numpy as np
from scipy.constants import g as standard_gravity

from drivers.ati.calibration import Calibration
from drivers.ati.foot_forces import ForceScales, no_forces
from drivers.dynamixel.mx106 import joint_state
from gaits.catalog import make_gait
from gaits.limits import frequency_limit
from gaits.plan import Walking
from model.kinematics.four_bar import Linkage
from model.motion import differentiate
from model.motion.dead_reckoning import advance as advance_odometry
from model.quasistatic.frame import prepare, solve_frame
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.contact import ContactSolution
from model.values.faults import Fault, FaultKind, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.readings import ServoReadings
from model.values.tick import Estimate, Inputs, Mode, Tick
from robot.config.robot_file import RobotConfig
from robot.control import body_watch_kernel
from robot.control.body_watch import BodyMemory, BodySeen, stop_reason_of, watch_body
from robot.control.estimator_stage import OdometryStage
from robot.control.file_model import model_of, odometry_stage
from robot.control.modes import GaitBook, Phase, Situation, advance, graver
from robot.control.recovery import Care, CareSeen, RecoveryMemory, care, legs_down
from robot.control.safety import Allowed, Refused, ServoVerdict, gate, watch_servos
from robot.control.state import ControllerState
from robot.run.rig import silent_readings

# Shaft speed is the slope over this many seconds of encoder readings.
RATE_WINDOW_S = 0.1
# Refused commands in a row before the robot halts.
REFUSED_LIMIT = 5
# A gap this long between two ticks is reported even if the next one came on time.
LONG_GAP_S = 0.05


class Controller:
    """The step and what it needs to know beforehand.

    Args:
        config: Robot file.
        calibrations: Calibration of each leg's transducer, None where there is none.
        armed: Whether torque may be asked for.
        rate_hz: Rate of the loop, or None for the robot file's.
    """

    def __init__(
        self,
        config: RobotConfig,
        calibrations: tuple[Calibration | None, ...],
        *,
        armed: bool,
        rate_hz: int | None = None,
    ) -> None:
        self.config = config
        self.armed = armed
        self.rate_hz = rate_hz if rate_hz is not None else config.loop.rate_hz
        self.period_ns = round(1e9 / self.rate_hz)
        robot = config.parameters
        self._scales = ForceScales(calibrations, config.force_sensor)
        self._no_forces = no_forces(robot.legs.count)
        self._linkage = Linkage(robot.linkage, robot.legs.shaft_position)
        self._odometry: OdometryStage | None = None
        if config.estimator.enabled:
            self._odometry = odometry_stage(config, self._linkage)
        self._weight_n = robot.body.mass * standard_gravity
        self._sensors = tuple(number > 0 for number in config.force_sensor.transducers.tolist())
        gaits = {name: make_gait(name, robot) for name in ("tripod", "metachronal")}
        self.book = GaitBook(
            gaits, {name: frequency_limit(gait, robot.servo) for name, gait in gaits.items()}
        )
        self._effects = model_of(config)
        # here, where nothing waits for it
        prepare()
        differentiate.prepare()
        body_watch_kernel.prepare()
        self._linkage.prepare()

    def initial(self) -> ControllerState:
        """Return the state before the first tick."""
        count = self.config.parameters.legs.count
        window = max(3, round(RATE_WINDOW_S * self.rate_hz) + 1)
        nan = readonly(np.full(count, np.nan))
        return ControllerState(
            index=0,
            phase=Phase(Mode.IDLE, None, None, StopReason.NONE),
            allowed=Allowed(JointCommand(0, nan, nan, torque=False)),
            refused=0,
            late=0,
            silent_reads=np.zeros(count, dtype=np.int64),
            bad_reads=np.zeros(count, dtype=np.int64),
            forces=self._no_forces,
            times_ns=np.zeros(window, dtype=np.int64),
            angles_rad=np.full((window, count), np.nan),
            estimate=Estimate(0, np.zeros(2), 0.0, np.full(3, np.nan), valid=False),
            body=BodyMemory.empty(count),
            recovery=RecoveryMemory.empty(count),
            began_ns=-1,
            odometry=self._odometry.initial() if self._odometry is not None else None,
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
        count = self.config.parameters.legs.count
        servos = inputs.servos if inputs.servos is not None else silent_readings(t_ns, count)
        names = self.config.servo_bus.names
        down = legs_down(state.recovery, inputs.faults, names)
        # a servo that started anew has another number for the same angle: what it says is not used
        usable = replace(servos, valid=readonly(servos.valid & ~down)) if down.any() else servos
        joints = joint_state(usable, self.config.servo_bus)
        forces = state.forces
        if inputs.forces:
            forces = self._scales.forces(inputs.forces[-1], joints.angle_rad)
        elif t_ns - forces.t_ns > self.config.force_sensor.silent_limit_s * 1e9:
            forces = self._no_forces
        verdict = watch_servos(
            servos,
            joints,
            state.allowed.command,
            state.silent_reads,
            state.bad_reads,
            self.config.limits,
            self.config.servo_bus,
        )
        late, timing_faults = self._timing(state, inputs)
        times_ns, angles_rad = _remember(state, joints, t_ns)
        began_ns = t_ns if state.index == 0 else state.began_ns
        rate = differentiate.latest_rate(times_ns, angles_rad)
        feet, contact, model_faults = self._model(state, joints, rate, t_ns)
        estimate = self._estimate(state, contact, t_ns)
        truly = forces
        if self._effects is not None:
            truly = self._effects.true_forces(forces, (t_ns - began_ns) * 1e-9)
        odometry = state.odometry
        if self._odometry is not None and odometry is not None:
            odometry, _ = self._odometry.step(odometry, t_ns, joints, forces, inputs.poses)
        body, body_faults = self._watch_body(state, joints, truly, contact, down)
        cared = self._care(state, inputs, servos, verdict, t_ns)
        stop = self._stop_reason(state, inputs, late, t_ns)
        stop = graver(stop, graver(cared.stop, stop_reason_of(body_faults)))
        situation = Situation(
            t_ns, inputs.request, stop, joints.angle_rad, self.armed, cared.pause, cared.resume
        )
        phase = advance(state.phase, situation, self.book)
        wished = self._wish(phase, t_ns, count)
        seeded = cared.resume is not None or bool(state.allowed.recover)
        allowed, refused, gate_faults = self._gate(wished, state, inputs, seeded=seeded)
        allowed = replace(allowed, recover=cared.ask)
        faults = (
            *inputs.faults,
            *verdict.faults,
            *timing_faults,
            *body_faults,
            *cared.faults,
            *gate_faults,
            *model_faults,
        )
        tick = Tick(
            t_ns=t_ns,
            index=state.index,
            mode=phase.mode,
            stop_reason=phase.stop_reason,
            inputs=inputs,
            joints=joints,
            forces=forces,
            gait_phase=phase.plan.phase(t_ns) if isinstance(phase.plan, Walking) else np.nan,
            wished=wished,
            sent=allowed.command,
            feet=feet,
            contact=contact,
            estimate=estimate,
            faults=faults,
            odometry=odometry.estimate if odometry is not None else None,
        )
        after = ControllerState(
            index=state.index + 1,
            phase=phase,
            allowed=allowed,
            refused=refused,
            late=late,
            silent_reads=verdict.silent_reads,
            bad_reads=verdict.bad_reads,
            forces=forces,
            times_ns=times_ns,
            angles_rad=angles_rad,
            estimate=estimate,
            body=body,
            recovery=cared.memory,
            began_ns=began_ns,
            odometry=odometry,
        )
        return after, tick

    def _watch_body(
        self,
        state: ControllerState,
        joints: JointState,
        forces: FootForces,
        contact: ContactSolution,
        down: BoolArray,
    ) -> tuple[BodyMemory, tuple[Fault, ...]]:
        seen = BodySeen(
            t_ns=joints.t_ns,
            mode=state.phase.mode,
            joints=joints,
            sent=state.allowed.command,
            forces=forces,
            contact=contact,
            estimate=state.estimate,
            weight_n=self._weight_n,
            sensors=self._sensors,
            down=down,
        )
        names = self.config.servo_bus.names
        return watch_body(state.body, seen, self.config.body_limits, names)

    def _care(
        self,
        state: ControllerState,
        inputs: Inputs,
        servos: ServoReadings,
        verdict: ServoVerdict,
        t_ns: int,
    ) -> Care:
        seen = CareSeen(
            t_ns=t_ns,
            faults=inputs.faults,
            verdict=verdict,
            valid=servos.valid,
            age_ns=servos.age_ns,
            holding=state.phase.mode is Mode.HOLD,
            torque=state.allowed.command.torque,
        )
        return care(state.recovery, seen, self.config.recovery, self.config.servo_bus.names)

    def _timing(self, state: ControllerState, inputs: Inputs) -> tuple[int, tuple[Fault, ...]]:
        late_s = inputs.timing.lateness_ns * 1e-9
        stood_still_s = inputs.timing.missed * self.period_ns * 1e-9
        if stood_still_s >= LONG_GAP_S:
            detail = f"the loop stood still for {stood_still_s * 1e3:.0f} ms"
            return state.late + 1, (Fault(FaultKind.LATE, "loop", detail),)
        if late_s <= self.config.loop.late_limit_s:
            return 0, ()
        return state.late + 1, (Fault(FaultKind.LATE, "loop", f"{late_s * 1e3:.1f} ms late"),)

    def _stop_reason(
        self, state: ControllerState, inputs: Inputs, late: int, t_ns: int
    ) -> StopReason:
        kinds = {fault.kind for fault in inputs.faults}
        last = self._last_heard(state, inputs)
        waited = state.refused or state.allowed.recover  # bringing a servo back takes its time
        silent_s = (t_ns - last.t_ns) * 1e-9 if last.torque and not waited else 0.0
        checks = (
            (FaultKind.LINK_LOST in kinds, StopReason.LINK_LOST),
            (FaultKind.SERVO_CORRUPT in kinds, StopReason.SERVO_FAULT),
            (state.refused >= REFUSED_LIMIT, StopReason.COMMAND_REFUSED),
            (late >= self.config.loop.late_ticks, StopReason.TIMING),
            (silent_s >= self.config.servo_bus.watchdog_s, StopReason.TIMING),
            (FaultKind.FORCE_SILENT in kinds, StopReason.FORCE_LOST),
            (FaultKind.LOG_WRITE in kinds, StopReason.LOG_FAILED),
        )
        return next((reason for found, reason in checks if found), StopReason.NONE)

    def _wish(self, phase: Phase, t_ns: int, count: int) -> JointCommand:
        if phase.plan is None:
            nan = readonly(np.full(count, np.nan))
            return JointCommand(t_ns, nan, nan, torque=False)
        angle, rate = phase.plan.at(t_ns)
        return JointCommand(t_ns, readonly(angle), readonly(rate), torque=True)

    def _last_heard(self, state: ControllerState, inputs: Inputs) -> JointCommand:
        """Return the last command, as new as the bus was busy: switching on takes a dozen transactions.

        The loop begins a new grid of deadlines behind them, so the deadline says when they were done.
        """
        last, timing = state.allowed.command, inputs.timing
        done_ns = timing.deadline_ns - (1 + timing.missed) * self.period_ns
        if not last.torque or done_ns <= last.t_ns:
            return last
        return replace(last, t_ns=done_ns)

    def _gate(
        self, wished: JointCommand, state: ControllerState, inputs: Inputs, *, seeded: bool
    ) -> tuple[Allowed, int, tuple[Fault, ...]]:
        last = self._last_heard(state, inputs)
        # switching on, or taking a servo up again: the driver holds where the shafts are
        if wished.torque and (seeded or not last.torque):
            last = replace(wished, torque=False)
        verdict = gate(wished, last, self.config.limits, self.config.servo_bus)
        if isinstance(verdict, Refused):
            fault = Fault(FaultKind.REFUSED, "safety gate", verdict.reason)
            return Allowed(state.allowed.command), state.refused + 1, (fault,)
        return verdict, 0, ()

    def _model(
        self, state: ControllerState, joints: JointState, rate_rad_s: FloatArray, t_ns: int
    ) -> tuple[FootMotion, ContactSolution, tuple[Fault, ...]]:
        """Feet, support and traction, with what the robot file adds to the nominal model."""
        if self._effects is None:
            feet = self._linkage.feet(joints.angle_rad, rate_rad_s)
            solution = solve_frame(feet, self.config.parameters.contact, self._weight_n)
        else:
            was = state.estimate
            dt_s = 0.0 if state.index == 0 else (t_ns - was.t_ns) * 1e-9
            pose = np.array([*was.position_m, was.yaw_rad])
            found = self._effects.solve(joints.angle_rad, rate_rad_s, pose, was.velocity_B, dt_s)
            feet, solution = found.feet, found.contact
        if solution.support.converged:
            return feet, solution, ()
        fault = Fault(FaultKind.NO_SUPPORT, "support", solution.support.reason)
        return feet, solution, (fault,)

    def _estimate(self, state: ControllerState, contact: ContactSolution, t_ns: int) -> Estimate:
        before = state.estimate
        if state.index == 0:
            before = replace(before, t_ns=t_ns)
        return advance_odometry(before, contact.traction.velocity_B, t_ns)


def _remember(state: ControllerState, joints: JointState, t_ns: int) -> tuple[IntArray, FloatArray]:
    """Append the newest angles to the window that shaft speed is taken from."""
    times, angles = np.empty_like(state.times_ns), np.empty_like(state.angles_rad)
    times[:-1], angles[:-1] = state.times_ns[1:], state.angles_rad[1:]
    times[-1] = t_ns if state.index == 0 else joints.t_ns
    angles[-1] = joints.angle_rad
    return times, angles
