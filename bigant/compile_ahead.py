"""What the second process of ``robot.console.second_compiler`` does: kernels of a drive, last ones first.

The first process begins with the estimator's largest kernels and ends with the virtual robot. This one goes
the other way, so that the two do not make the same kernel at the same time.
"""

import os
from threading import Thread

from bigant.one_thread import one_thread

INPUT = 0


def main() -> None:
    """Make all machine code of a virtual drive but the estimator's largest kernel, and keep it."""
    Thread(target=_leave_with_parent, daemon=True).start()
    one_thread()
    compile_ahead()


def compile_ahead() -> None:
    """Load or make it: of the virtual robot, of the estimator, and of the diagnosis."""
    from model.estimator import (
        gate_kernel,
        health,
        kalman,
        measurements,
        process,
        report,
        senses,
        tolerance_kernel,
    )
    from model.motion import differentiate
    from model.traction import frames
    from robot.config.robot_file import load_robot
    from robot.virtual.rehearsal import silent
    from robot.virtual.twin_run import WalkPlan, make_twin, walk_fast

    config = load_robot()
    walk_fast(config, make_twin(config, (), seed=0), WalkPlan("tripod", 0.2, 0.1, 0.0), silent)
    for prepare in (
        differentiate.prepare, kalman.prepare, gate_kernel.prepare, report.prepare,
        measurements.prepare, health.prepare, senses.prepare, frames.prepare, process.prepare,
        tolerance_kernel.prepare,
    ):  # fmt: skip
        prepare()


def _leave_with_parent() -> None:
    while os.read(INPUT, 1):
        pass
    os._exit(0)


if __name__ == "__main__":
    main()
