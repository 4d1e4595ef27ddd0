"""A hexapod on stairs: level patches of ground at several heights, felt as a change of leg length.

Which patch a foot is over depends on where the body is, and that on every frame before: the frames
are solved one by one, unlike on level ground where they could be solved in any order.
"""

from dataclasses import dataclass

import numpy as np
from scipy.constants import g as standard_gravity

from model.errors import ModelError
from model.motion.se2 import compose, exponential
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.systems.foot_path import FootPath, walk
from model.systems.system import System, box, equal_contacts, even_times
from model.values.arrays import FloatArray
from model.values.legs import FootMotion

# A hexapod of the size of BigANT, but with feet that follow a path; assumed.
MASS_KG = 6.0
HIP_X_M, HIP_Y_M, FOOT_Y_M, STANCE_M = 0.22, 0.12, 0.25, 0.14
BODY_LENGTH_M, BODY_WIDTH_M = 0.56, 0.24
# HL, ML, FL, HR, MR, FR: two tripods half a cycle apart
DELAY = (0.0, 0.5, 0.0, 0.5, 0.0, 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Level ground with edges across the way.

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


def two_steps(rise_m: float = 0.03) -> Steps:
    """Two steps up by ``rise_m`` each [m]."""
    return Steps(np.array([0.45, 0.95]), rise_m * np.arange(3.0))


@dataclass(frozen=True, slots=True, eq=False)
class StairWalk:
    """A walk over steps.

    Attributes:
        system: The walk with the ground met under each foot.
        steps: The ground.
        poses: Where the body was at each frame and after the last: x, y [m], yaw [rad], (F + 1, 3).
    """

    system: System
    steps: Steps
    poses: FloatArray


def ground_under(feet_xy_W: FloatArray, steps: Steps) -> FloatArray:  # noqa: N803
    """Height of the ground under points of the world, (..., 2) [m] to (...) [m]."""
    height: FloatArray = steps.heights_m[
        np.searchsorted(steps.edges_x_m, feet_xy_W[..., 0], side="right")
    ]
    return height


def climb(
    steps: Steps | None = None,
    *,
    cycles: float = 15.0,
    frequency_hz: float = 0.5,
    rate_hz: float = 100.0,
    stroke_m: float = 0.10,
    lift_m: float = 0.07,
    duty: float = 0.6,
    stiffness: float = 3000.0,
    mu: float = 0.8,
    law: FrictionLaw = FrictionLaw.VISCOUS,
    tilt_coupling: bool = False,
) -> StairWalk:
    """Walk a hexapod over steps with an alternating tripod. Foot order: HL, ML, FL, HR, MR, FR.

    Args:
        steps: The ground; ``two_steps()`` if None.
        cycles: Length of the motion.
        frequency_hz: Gait cycles a second.
        rate_hz: Frames a second.
        stroke_m: Way of each foot in stance [m].
        lift_m: How high feet are lifted; more than a step [m].
        duty: Stance share of the cycle.
        stiffness: Of each leg [N/m].
        mu: Friction coefficient.
        law: Friction law.
        tilt_coupling: As in ``solve_frames``.

    Raises:
        ModelError: Values that make no gait.
    """
    steps = two_steps() if steps is None else steps
    time_s = even_times(cycles / frequency_hz, rate_hz)
    left = np.array([1.0, 1, 1, -1, -1, -1])
    ahead = np.array([-1.0, 0, 1, -1, 0, 1])
    rest = np.column_stack([HIP_X_M * ahead, FOOT_Y_M * left, np.full(6, -STANCE_M)])
    phase = frequency_hz * time_s[:, None] - np.array(DELAY)
    feet = walk(FootPath(stroke_m, lift_m, duty), rest, phase, np.array(frequency_hz))
    contact = equal_contacts(6, stiffness, mu)
    weight_n = MASS_KG * standard_gravity
    ground = np.zeros((len(time_s), 6))
    poses = np.zeros((len(time_s) + 1, 3))
    for frame in range(len(time_s)):
        ground[frame] = ground_under(_in_world(poses[frame], feet.position_m[frame]), steps)
        one = slice(frame, frame + 1)
        solved = solve_frames(
            FootMotion(feet.position_m[one], feet.velocity_m_s[one]),
            contact,
            weight_n,
            law=law,
            tilt_coupling=tilt_coupling,
            ground_m=ground[one],
        )
        # a frame without an answer leaves the body where it is
        velocity = solved.velocity_B[0] if solved.valid[0] else np.zeros(3)
        poses[frame + 1] = compose(poses[frame], exponential(velocity / rate_hz))
    system = System(
        name="stairs",
        description=f"hexapod over {len(steps.edges_x_m)} steps, {frequency_hz:g} Hz",
        time_s=time_s,
        feet=feet,
        contact=contact,
        weight_n=weight_n,
        ground_m=ground,
        outline_B=box(BODY_LENGTH_M, BODY_WIDTH_M),
        hips_B=np.column_stack([HIP_X_M * ahead, HIP_Y_M * left]),
    )
    return StairWalk(system, steps, poses)


def _in_world(pose: FloatArray, feet_B: FloatArray) -> FloatArray:  # noqa: N803
    """Feet (N, 3) seen from above in the world, (N, 2) [m]; slopes are too small to shift them."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    world: FloatArray = pose[:2] + feet_B[:, :2] @ np.array([[c, s], [-s, c]])
    return world
