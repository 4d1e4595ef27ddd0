"""What the blocks of a step hand to each other, and what is remembered for the next tick: the same."""

from dataclasses import dataclass

from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.contact import ContactSolution
from model.values.estimate import Estimate
from model.values.faults import Fault, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.quick import quick
from model.values.readings import ServoReadings
from model.values.tick import DeadReckoning
from robot.control.body_watch import BodyMemory
from robot.control.estimator_stage import StageMemory
from robot.control.modes import Phase
from robot.control.recovery import RecoveryPlan
from robot.control.safety import Allowed, ServoVerdict


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Senses:
    """What the sensors measured in one tick.

    Attributes:
        servos: Servo readings as they came.
        joints: The same, calibrated; NaN for servos that are silent or down.
        forces: Latest measured foot forces; absent after too long a silence.
        down: Legs whose servos have lost their torque, (N,) bool.
        last: The last command, dated when the servos had it.
        times_ns: Times of the latest shaft angles, this tick's last, (W,).
        angles_rad: Latest shaft angles, (W, N).
        began_ns: Time of the first tick.
    """

    servos: ServoReadings
    joints: JointState
    forces: FootForces
    down: BoolArray
    last: JointCommand
    times_ns: IntArray
    angles_rad: FloatArray
    began_ns: int


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Estimates:
    """What model and estimator make of the senses.

    Attributes:
        feet: Unloaded feet.
        contact: Support and traction.
        forces: Foot forces without the sensors' errors that the robot file knows.
        dead_reckoning: The model's velocity added up.
        estimate: What the estimator makes of shafts, forces and poses; None where it is switched off.
        estimator: What the estimator remembers.
        faults: What the model found no answer to.
    """

    feet: FootMotion
    contact: ContactSolution
    forces: FootForces
    dead_reckoning: DeadReckoning
    estimate: Estimate | None
    estimator: StageMemory | None
    faults: tuple[Fault, ...]


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """What is to be done.

    Attributes:
        phase: Mode, plan and stop reason.
        recovery: What is done about servos without torque.
        servos: Verdict on the servos.
        body: What the watch over the body remembers.
        late: Late ticks in a row.
        faults: Faults of the watches, the loop's timing and the recovery.
    """

    phase: Phase
    recovery: RecoveryPlan
    servos: ServoVerdict
    body: BodyMemory
    late: int
    faults: tuple[Fault, ...]


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """What goes to the servos.

    Attributes:
        wished: What the plan asks for.
        allowed: What the safety gate lets through.
        refused: Commands refused in a row.
        faults: The gate's refusal.
    """

    wished: JointCommand
    allowed: Allowed
    refused: int
    faults: tuple[Fault, ...]


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ControllerState:
    """Everything the controller remembers from one tick to the next: the last output of its blocks.

    Attributes:
        index: Ticks done.
        senses: What the sensors measured.
        estimates: What model and estimator made of it.
        decision: What was to be done.
        command: What went to the servos.
    """

    index: int
    senses: Senses
    estimates: Estimates
    decision: Decision
    command: Command

    @property
    def allowed(self) -> Allowed:
        """What goes to the bus: the command that the safety gate last let through."""
        return self.command.allowed

    @property
    def stop_reason(self) -> StopReason:
        """Why the run is ending, NONE while it goes on."""
        return self.decision.phase.stop_reason
