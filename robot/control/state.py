"""What the controller remembers from one tick to the next."""

from dataclasses import dataclass

from model.values.arrays import FloatArray, IntArray
from model.values.faults import StopReason
from model.values.legs import FootForces
from model.values.tick import DeadReckoning
from robot.control.body_watch import BodyMemory
from robot.control.estimator_stage import StageMemory
from robot.control.modes import Phase
from robot.control.recovery import RecoveryMemory
from robot.control.safety import Allowed


@dataclass(frozen=True, slots=True, eq=False)
class ControllerState:
    """Everything the controller remembers from one tick to the next.

    Attributes:
        index: Ticks done.
        phase: Mode, plan and stop reason.
        allowed: The command last let through by the safety gate.
        refused: Commands refused in a row.
        late: Late ticks in a row.
        silent_reads: Reads in a row without an answer, (N,).
        bad_reads: Reads in a row with a value beyond its limit, (N,).
        forces: Latest measured foot forces.
        times_ns: Times of the latest shaft angles, (W,).
        angles_rad: Latest shaft angles, (W, N).
        dead_reckoning: Dead-reckoned pose.
        body: What the watch over the body remembers.
        recovery: Servos that are being brought back.
        began_ns: Time of the first tick.
        estimator: What the estimator remembers; None where it is switched off.
    """

    index: int
    phase: Phase
    allowed: Allowed
    refused: int
    late: int
    silent_reads: IntArray
    bad_reads: IntArray
    forces: FootForces
    times_ns: IntArray
    angles_rad: FloatArray
    dead_reckoning: DeadReckoning
    body: BodyMemory
    recovery: RecoveryMemory
    began_ns: int
    estimator: StageMemory | None

    @property
    def stop_reason(self) -> StopReason:
        """Why the run is ending, NONE while it goes on."""
        return self.phase.stop_reason
