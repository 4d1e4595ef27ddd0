"""A hexapod on stairs: level patches of ground at several heights, felt as a change of leg length.

Which patch a foot is over depends on where the body is, and that on every frame before: the frames
are solved one by one, unlike on level ground where they could be solved in any order.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.motion.se2 import compose, exponential, turned
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.systems.foot_path import walk
from model.systems.system import RATE_HZ, System, box, equal_contacts, even_times
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion

FREQUENCY_HZ = 0.5
# A hexapod of the size of BigANT, but with feet that follow a path; assumed.
MASS_KG = 6.0
HIP_X_M, HIP_Y_M, FOOT_Y_M, STANCE_M = 0.22, 0.12, 0.25, 0.14
BODY_LENGTH_M, BODY_WIDTH_M = 0.56, 0.24
STIFFNESS_N_M, MU = 3000.0, 0.8
# HL, ML, FL, HR, MR, FR: two tripods half a cycle apart
AHEAD = np.array([-1.0, 0, 1, -1, 0, 1])
LEFT = np.array([1.0, 1, 1, -1, -1, -1])
DELAY = np.array([0.0, 0.5, 0.0, 0.5, 0.0, 0.5])


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Level ground with edges across the walk.

    Attributes:
        edges_x_m: World x of each edge, growing, (S,) [m].
        heights_m: Height of the ground before, between and after the edges, (S + 1,) [m].

    Raises:
        ModelError: Edges that do not grow, or not one height more than edges.
    """

    edges_x_m: FloatArray
    heights_m: FloatArray

    def __post_init__(self) -> None:
        if self.heights_m.shape != (len(self.edges_x_m) + 1,):
            raise ModelError("steps need one height more than edges")
        if not (np.isfinite(self.heights_m).all() and (np.diff(self.edges_x_m) > 0).all()):
            raise ModelError("edges of steps must grow along x, and heights be numbers")


TWO_STEPS = Steps(np.array([0.45, 0.95]), 0.03 * np.arange(3.0))


def ground_under(pose: FloatArray, feet_B: FloatArray, steps: Steps) -> FloatArray:  # noqa: N803
    """Height of the ground under feet; slopes are too small to shift them.

    Args:
        pose: x, y [m], yaw [rad] of the body in the world, (3,).
        feet_B: (N, 3) [m].
        steps: The ground.

    Returns:
        (N,) [m].
    """
    x = pose[0] + turned(feet_B[:, 0], feet_B[:, 1], pose[2])[0]
    height: FloatArray = steps.heights_m[np.searchsorted(steps.edges_x_m, x, side="right")]
    return height


def climb(
    steps: Steps = TWO_STEPS,
    *,
    cycles: float = 15.0,
    rate_hz: float = RATE_HZ,
    law: FrictionLaw = FrictionLaw.VISCOUS,
    tilt_coupling: bool = False,
) -> System:
    """Walk a hexapod over steps with an alternating tripod. Foot order: HL, ML, FL, HR, MR, FR.

    Args:
        steps: The ground.
        cycles: Length of the motion.
        rate_hz: Frames a second.
        law: Friction law.
        tilt_coupling: As in ``solve_frames``.

    Returns:
        The walk, with the height of the ground that each foot met.

    Raises:
        ModelError: Too few frames.
    """
    time_s = even_times(cycles / FREQUENCY_HZ, rate_hz)
    rest = np.column_stack([HIP_X_M * AHEAD, FOOT_Y_M * LEFT, np.full(6, -STANCE_M)])
    phase = FREQUENCY_HZ * time_s[:, None] - DELAY
    feet = walk(rest, phase, FREQUENCY_HZ, stroke_m=0.10, lift_m=0.07, duty=0.6)
    contact = equal_contacts(6, STIFFNESS_N_M, MU)
    weight_n = MASS_KG * STANDARD_GRAVITY
    ground = np.zeros((len(time_s), 6))
    pose = np.zeros(3)
    for frame in range(len(time_s)):
        ground[frame] = ground_under(pose, feet.position_m[frame], steps)
        one = slice(frame, frame + 1)
        solved = solve_frames(
            FootMotion(feet.position_m[one], feet.velocity_m_s[one]),
            contact,
            weight_n,
            law=law,
            tilt_coupling=tilt_coupling,
            ground_m=ground[one],
        )
        if solved.valid[0]:  # a frame without an answer leaves the body where it is
            pose = compose(pose, exponential(solved.velocity_B[0] / rate_hz))
    return System(
        name="stairs",
        description=f"hexapod over {len(steps.edges_x_m)} steps, {FREQUENCY_HZ:g} Hz",
        time_s=time_s,
        feet=feet,
        contact=contact,
        weight_n=weight_n,
        ground_m=ground,
        outline_B=box(BODY_LENGTH_M, BODY_WIDTH_M),
        hips_B=np.column_stack([HIP_X_M * AHEAD, HIP_Y_M * LEFT]),
    )
