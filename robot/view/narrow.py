"""The live screen for a terminal of less than 80 columns, as on a phone: the same, in 40."""

import textwrap
from collections.abc import Iterator

import numpy as np

from model.values.arrays import FloatArray
from model.values.faults import StopReason
from model.values.machine_names import MachineNames
from model.values.tick import Tick
from robot.console.table import number_text

BAR = 10
WIDTH = 40


def narrow_lines(
    tick: Tick, names: MachineNames, seconds: float, worst_late_ns: int, missed: int
) -> list[str]:
    """Return what is measured, as lines of at most 40 letters (longer names of joints make them wider)."""
    late_ms, worst_ms = tick.inputs.timing.lateness_ns * 1e-6, worst_late_ns * 1e-6
    phase = tick.gait_phase
    gait = "-"
    if np.isfinite(phase):
        done = int((phase % 1.0) * BAR)
        gait = f"[{'#' * done}{'.' * (BAR - done)}] {phase:.1f} cycles"
    lines = [f"{tick.mode.name:<7} {gait}"]
    if tick.stop_reason is not StopReason.NONE:
        lines.append(f"stopping: {tick.stop_reason.name}")
    lines.append(f"{seconds:.1f} s  late {late_ms:.1f} max {worst_ms:.1f} ms")
    lines += [f"missed {missed} periods"] if missed else []
    joints, legs = tick.joints, (tick.forces.force_n[:, 2], tick.contact.support.load_n)
    of_joints = ((joints.angle_rad, 2, 7), (joints.current_a, 2, 6), (joints.temperature_c, 0, 4))
    of_legs = ((legs[0], 1, 7), (legs[1], 1, 7))
    shafts, loads = "    rad     A   C", "   Fz N  model"
    if names.one_joint_a_leg:
        lines += ["", *_rows("leg", shafts + loads, names.legs, (*of_joints, *of_legs))]
    else:
        lines += ["", *_rows("joint", shafts, names.joints, of_joints)]
        lines += ["", *_rows("leg", loads, names.legs, of_legs)]
    return [*lines, "", *_motion(tick)]


def _rows(
    word: str, head: str, names: tuple[str, ...], columns: tuple[tuple[FloatArray, int, int], ...]
) -> Iterator[str]:
    """A heading and lines of numbers; each column with its digits and its width."""
    width = max(len(word), *map(len, names))
    yield f"{word:<{width}}{head}"
    for at, name in enumerate(names):
        cells = (number_text(values[at], digits, size) for values, digits, size in columns)
        yield f"{name:<{width}}{''.join(cells)}"


def _motion(tick: Tick) -> Iterator[str]:
    """Body velocity and pose, by source."""
    yield "          vx mm/s  vy mm/s  yaw rad/s"
    sources = [("model", tick.contact.traction.velocity_B)]
    if tick.estimate is not None:
        sources.append(("estimate", tick.estimate.velocity_B))
    if tick.inputs.truth is not None:
        sources.append(("true", tick.inputs.truth.planar_velocity_B))
    for name, (vx, vy, turn) in sources:
        cells = number_text(vx * 1e3, 1, 8), number_text(vy * 1e3, 1, 9), number_text(turn, 3, 11)
        yield f"{name:<9}{''.join(cells)}"
    estimate = tick.estimate
    x, y, yaw = tick.dead_reckoning.pose if estimate is None else estimate.pose
    yield f"at x {number_text(x * 1e3, 0)} y {number_text(y * 1e3, 0)} mm, yaw {number_text(yaw, 2)} rad"
    if estimate is not None:
        sd = np.sqrt(np.diagonal(estimate.pose_covariance))
        spread = ", ".join(
            f"{axis} {one * 1e3:.1f}" for axis, one in zip("xy", sd[:2], strict=True)
        )
        yield f"sd {spread} mm: {estimate.health.value}"
        yield from textwrap.wrap(estimate.reason, WIDTH)
