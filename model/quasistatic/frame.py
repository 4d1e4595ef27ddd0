"""One frame of the whole model: support, then traction (the paper's steps A and B).

Called once a tick: one compiled call in, one array of numbers out, in microseconds. Or for all frames of a
walk at once, with the same answers to the bit.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.errors import ModelError
from model.support.kernel import ROWS, support_kernel
from model.traction.kernel import (
    CREEP_SPEED_M_S,
    coulomb_scale,
    foot_speeds,
    lay_anisotropy,
    traction_kernel,
)
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.contact import ContactSolution, Support, Traction
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

NOT_A_NUMBER = 1
NEGATIVE = 7
WORDS = (
    "",
    "a foot position, velocity, stiffness or the load is not a number",
    "there are no feet",
    "the centre of mass is not above the feet: the robot tips",
    "the search for the contact set did not end; report the pose",
    "fewer than two feet are loaded",
    "the loaded feet stand in one point: turning is not determined",
    "load and stiffness must be positive",
)


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    # for read-only inputs, which writable ones fit too, and for nothing else after
    compile_for(frame_kernel, *given(2, 2, 1, 1, 2), NUMBER, *out(1), *out(1, kind=FLAG))


def solve_frame(feet: FootMotion, contact: ContactParameters, weight_n: float) -> ContactSolution:
    """Predict loads, body velocity, slip and foot forces from the feet.

    The viscous ansatz knows forces up to one scale a frame. They are put in newtons by the scale that
    brings the horizontal forces nearest, in least squares, to Coulomb's law at the same slips; the balance
    holds for any scale. A robot at rest has no horizontal forces, not undefined ones.

    Args:
        feet: Unloaded feet of one frame in the body frame, (N, 3) each.
        contact: Leg springs and friction.
        weight_n: Weight carried [N].

    Raises:
        ModelError: Shapes do not fit.
    """
    position, velocity = feet.position_m, feet.velocity_m_s
    count = position.shape[0]
    if position.shape != (count, 3) or velocity.shape != (count, 3) or count == 0:
        raise ModelError(f"feet must be (N, 3), not {position.shape} and {velocity.shape}")
    if contact.stiffness.shape != (count,) or contact.anisotropy.shape != (count, 2):
        raise ModelError(f"the contact parameters are not those of {count} legs")
    status, reason, numbers, loaded = _solved(feet, contact, weight_n)
    velocity_B, load_n, slip_B, force_B = _parts(readonly(numbers), count)  # noqa: N806
    pose = numbers[:3].tolist()
    return _solution((status, reason), pose, velocity_B, load_n, slip_B, force_B, readonly(loaded))


def _parts(numbers: FloatArray, count: int) -> tuple[FloatArray, ...]:
    """Velocity, loads, slips and forces of N feet in what ``frame_kernel`` writes, (..., 6 + 6 N)."""
    frames, slip_at, force_at = numbers.shape[:-1], 6 + count, 6 + 3 * count
    return (
        numbers[..., 3:6], numbers[..., 6:slip_at],
        numbers[..., slip_at:force_at].reshape(*frames, count, 2),
        numbers[..., force_at:].reshape(*frames, count, 3),
    )  # fmt: skip


def _solution(
    verdict: tuple[int, int], pose: list[float], velocity_B: FloatArray, load_n: FloatArray,  # noqa: N803
    slip_B: FloatArray, force_B: FloatArray, loaded: BoolArray,  # noqa: N803
) -> ContactSolution:  # fmt: skip
    """What ``frame_kernel`` returns and writes, as values."""
    status, reason = verdict
    words, (slope_x, slope_y, height) = WORDS[reason], pose
    carried = status >= 0
    support = Support(
        carried, "" if carried else words, height, slope_x, slope_y, load_n, loaded, max(status, 0)
    )
    why = words if carried else f"no support: {words}"
    return ContactSolution(support, Traction(reason == 0, why, velocity_B, slip_B, force_B))


@dataclass(frozen=True, slots=True, eq=False)
class FrameRows:
    """What ``solve_frame`` says of T frames of N feet; NaN where there is no answer.

    Attributes:
        numbers: Of ``frame_kernel``, (T, 6 + 6 N).
        loaded: Which feet carry, (T, N).
        verdicts: What ``frame_kernel`` returns, (T, 2).
    """

    numbers: FloatArray
    loaded: BoolArray
    verdicts: IntArray

    @property
    def answered(self) -> BoolArray:
        """Which frames have an answer, (T,)."""
        answered: BoolArray = self.verdicts[:, 1] == 0
        return answered

    @property
    def pose(self) -> FloatArray:
        """slope_x, slope_y, height [m], (T, 3)."""
        return self.numbers[:, :3]

    @property
    def parts(self) -> tuple[FloatArray, ...]:
        """Velocity (T, 3), loads (T, N), slips (T, N, 2) and forces (T, N, 3)."""
        return _parts(self.numbers, self.loaded.shape[1])

    def solution(self, k: int) -> ContactSolution:
        """Return that of frame k."""
        status, reason = self.verdicts[k].tolist()
        velocity_B, load_n, slip_B, force_B = _parts(self.numbers[k], self.loaded.shape[1])  # noqa: N806
        return _solution(
            (status, reason), self.pose[k].tolist(), velocity_B, load_n, slip_B, force_B,
            self.loaded[k],
        )  # fmt: skip


def solve_rows(feet: FootMotion, contact: ContactParameters, weight_n: float) -> FrameRows:
    """``solve_frame`` of each of T frames, (T, N, 3), to the bit."""
    numbers, loaded, verdicts = _frames(feet, contact, weight_n)
    return FrameRows(readonly(numbers), readonly(loaded), readonly(verdicts))


class WalkSolution(NamedTuple):
    """What ``solve_frame`` says of T frames; NaN where there is no answer.

    Attributes:
        height_m: Of the body origin over the ground, (T,) [m].
        velocity_B: vx, vy [m/s], yaw rate [rad/s], (T, 3).
        force_B: On each foot, (T, N, 3) [N].
    """

    height_m: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_B: FloatArray  # noqa: N815


def solve_walk(feet: FootMotion, contact: ContactParameters, weight_n: float) -> WalkSolution:
    """``solve_frame`` of every frame of a walk.

    Args:
        feet: Unloaded feet in the body frame, (T, N, 3) each.
        contact: Leg springs and friction.
        weight_n: Weight carried [N].

    Raises:
        ModelError: Shapes do not fit.
    """
    position, velocity = feet.position_m, feet.velocity_m_s
    shape = (len(position), len(contact.mu), 3)
    if position.shape != shape or velocity.shape != shape or 0 in shape[1:]:
        raise ModelError(f"feet must be {shape}, not {position.shape} and {velocity.shape}")
    numbers, _, _ = _frames(feet, contact, weight_n)
    velocity_B, _, _, force_B = _parts(numbers, shape[1])  # noqa: N806 - frame suffix
    return WalkSolution(numbers[:, 2].copy(), velocity_B.copy(), force_B.copy())


def _frames(
    feet: FootMotion, contact: ContactParameters, weight_n: float
) -> tuple[FloatArray, BoolArray, IntArray]:
    """What ``frames_kernel`` writes for T frames."""
    frames, count = len(feet.position_m), len(contact.mu)
    numbers, loaded = np.empty((frames, 6 + 6 * count)), np.empty((frames, count), np.bool_)
    verdicts = np.empty((frames, 2), np.int64)
    prepare()
    compile_for(
        frames_kernel, *given(3, 3, 1, 1, 2), NUMBER, *out(2), *out(2, kind=FLAG),
        *out(2, kind=COUNT),
    )  # fmt: skip
    frames_kernel(
        np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, weight_n, numbers, loaded, verdicts,
    )  # fmt: skip
    return numbers, loaded, verdicts


def _solved(
    feet: FootMotion, contact: ContactParameters, weight_n: float
) -> tuple[int, int, FloatArray, BoolArray]:
    """What ``frame_kernel`` returns and writes."""
    count = len(feet.position_m)
    numbers, loaded = np.empty(6 + 6 * count), np.empty(count, dtype=np.bool_)
    status, reason = frame_kernel(
        np.ascontiguousarray(feet.position_m), np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness, contact.mu, contact.anisotropy, weight_n, numbers, loaded,
    )  # fmt: skip
    return status, reason, numbers, loaded


@compiled
def frame_kernel(
    feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray, mu: FloatArray,
    anisotropy: FloatArray, load: float, numbers: FloatArray, loaded: BoolArray,
) -> tuple[int, int]:  # fmt: skip
    """Support and viscous-Coulomb traction of one frame.

    Args:
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: (N, 2).
        load: [N].
        numbers: Out: slope_x, slope_y, height, vx, vy, yaw rate, then N loads, N x 2 slips (NaN in the
            air), N x 3 forces; NaN where there is no answer.
        loaded: Out: (N,).

    Returns:
        Steps of the contact search (negative: none found), and the reason (0 is fine).
    """
    count = feet.shape[0]
    numbers[:] = np.nan
    loaded[:] = False
    proper = load > 0.0
    # copies that may be written, as the estimator has them: one set of machine code serves both
    place, speed = np.empty((count, 3)), np.empty((count, 3))
    springs, grip = np.empty(count), np.empty(count)
    for k in range(count):
        proper = proper and stiffness[k] > 0.0
        springs[k], grip[k] = stiffness[k], mu[k]
        for i in range(3):
            place[k, i], speed[k, i] = feet[k, i], feet_velocity[k, i]
    if not proper:
        return -NEGATIVE, NEGATIVE
    work, ansatz = np.empty((ROWS, count)), np.empty((count, 2))
    lay_anisotropy(anisotropy, work)
    pose, velocity, loads = numbers[:3], numbers[3:6], numbers[6 : 6 + count]
    slip = numbers[6 + count : 6 + 3 * count].reshape(count, 2)
    force = numbers[6 + 3 * count :].reshape(count, 3)
    status = support_kernel(place, np.zeros(count), springs, load, pose, loads, work)
    if status < 0:
        return status, -status
    for k in range(count):
        loaded[k] = loads[k] > 0.0
    if not foot_speeds(speed, work):
        return status, NOT_A_NUMBER
    reason = traction_kernel(work, loads, grip, velocity, slip, ansatz)
    if reason != 0:
        velocity[:] = np.nan
        slip[:] = np.nan
        return status, reason
    scale = coulomb_scale(slip, ansatz, CREEP_SPEED_M_S)
    for k in range(count):
        force[k, 0] = scale * ansatz[k, 0]
        force[k, 1] = scale * ansatz[k, 1]
        force[k, 2] = loads[k]
        if not loaded[k]:
            slip[k, 0] = slip[k, 1] = np.nan
    return status, 0


@in_place
@compiled
def frames_kernel(
    feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray, mu: FloatArray,
    anisotropy: FloatArray, load: float, numbers: FloatArray, loaded: BoolArray,
    verdicts: IntArray,
) -> None:  # fmt: skip
    """``frame_kernel`` of T frames; ``verdicts`` is what it returns of each, (T, 2)."""
    for frame in range(len(feet)):
        verdicts[frame, 0], verdicts[frame, 1] = frame_kernel(
            feet[frame],
            feet_velocity[frame],
            stiffness,
            mu,
            anisotropy,
            load,
            numbers[frame],
            loaded[frame],
        )
