"""A walk of a physical twin through the whole stack: controller, servo bus and force unit, byte by byte."""

import numpy as np

from model.errors import ModelError, RecordError
from model.values.faults import StopReason
from model.values.readings import BodyTruth
from model.values.tick import Mode, Tick
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.hardware import open_twin
from robot.run.loop import TickSink, run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.virtual.twin_log import BeginLog
from robot.virtual.twin_rows import TwinRows, trial_header, trial_of
from robot.virtual.twin_run import Progress, WalkPlan
from sim_hw.twin.motion_capture import Poses
from sim_hw.twin.twin import Twin


class _Collector:
    """Keeps what a trial needs of the ticks of a walk, and hands every tick on."""

    def __init__(self, plan: WalkPlan, sink: TickSink | None, progress: Progress) -> None:
        self.error: RecordError | None = None
        self.rows = TwinRows()
        self.truths: list[BodyTruth] = []
        self._plan, self._sink, self._progress = plan, sink, progress

    def write(self, tick: Tick) -> None:
        """Take one tick."""
        if self._sink is not None:
            self._sink.write(tick)
            self.error = self._sink.error
        rows, length_ns = self.rows, round(self._plan.seconds * 1e9)
        if tick.mode is not Mode.WALK or (rows.t_ns and tick.t_ns - rows.t_ns[0] >= length_ns):
            return
        if tick.inputs.truth is None:
            raise ModelError("the cameras saw nothing")
        rows.t_ns.append(tick.t_ns)
        rows.command_rad.append(tick.sent.angle_rad)
        rows.joints.append(tick.joints)
        rows.forces.append(tick.forces)
        self.truths.append(tick.inputs.truth)
        self._progress(min(1.0, (tick.t_ns - rows.t_ns[0]) / length_ns))


def walk_through_bytes(
    config: RobotConfig, twin: Twin, plan: WalkPlan, begin: BeginLog | None, progress: Progress
) -> Trial:
    """Walk through the virtual bus and force unit, with the whole controller, and return the trial.

    Args:
        config: Robot file: what controller and safety gate believe.
        twin: What walks.
        plan: How.
        begin: Opens the log that every tick goes to as well, for this rig and controller.
        progress: Told the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    rig, _ = open_twin(config, twin, seed=twin.seed, armed=True, with_forces=True)
    controller = Controller(config, rig.calibrations, armed=True)
    script = Script(plan.gait, plan.frequency_hz, plan.steer, None, plan.seconds)
    log = begin(rig, controller) if begin is not None else None
    collector = _Collector(plan, log, progress)
    try:
        result = run(rig, controller, ScriptedOperator(script, Interrupts()), collector, None)
    finally:
        rig.close()
        if log is not None:
            log.close()
    if log is not None and log.error is not None:
        raise log.error
    if result.reason is not StopReason.COMPLETED:
        raise ModelError(f"the walk stopped early ({result.reason.name}): {result.detail}")
    truths = collector.truths
    poses = Poses(
        t_ns=np.array([truth.t_ns for truth in truths]),
        position_W=np.array([truth.position_W for truth in truths]),
        quaternion_xyzw=np.array([truth.quaternion_xyzw for truth in truths]),
        foot_position_W=np.array([truth.foot_position_W for truth in truths]),
    )
    header = trial_header(config, plan.gait, plan.frequency_hz, twin.sensors.noise)
    return trial_of(collector.rows, poses, header)
