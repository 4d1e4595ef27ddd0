"""The viscous-Coulomb local connection in numpy: what the compiled balance is tested against.

In body axes a foot at q moves over the ground with slip = v + w S q + q', where q' is its velocity in
the body, (v, w) the body's and S the quarter turn. The ansatz is F = -D slip with D = mu N (I + a a^T),
bilinear in load and slip. Balance of forces and of the moment about z (right hand, erratum E5) gives

    (sum G^T D G) (v, w) = - sum G^T D q',      G = [I, S q]

with the minus sign that the appendix drops (erratum E1). It is the minimum of the dissipation
sum slip^T D slip / 2, so it exists whenever the loaded feet do not all stand in one point.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.contact import ContactSolution, Support, Traction
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.oracles.support import solve_support

# Smallest ratio of the eigenvalues of the balance (lengths scaled by the feet's spread).
CONDITION_LIMIT = 1e-9
# Slip below which a foot is taken to rest when forces are put on a scale [m/s].
CREEP_SPEED_M_S = 1e-3
FEWEST_FEET = 2


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """The linear map from foot velocities in the body to body velocity, for one frame.

    Attributes:
        matrix: (3, N, 2): (vx, vy, yaw rate) = sum over feet and axes of matrix * foot velocity.
        drag: D of each foot, (N, 2, 2) [N s/m up to one scale for the frame].
        lever: G of each foot, (N, 2, 3).
        valid: False when the balance is ill-conditioned; ``reason`` says why.
        reason: Empty when valid.
    """

    matrix: FloatArray
    drag: FloatArray
    lever: FloatArray
    valid: bool
    reason: str


def connection(
    feet_xy_B: FloatArray,  # noqa: N803
    load_n: FloatArray,
    mu: FloatArray,
    anisotropy: FloatArray,
) -> Connection:
    """Build the local connection of one frame.

    Args:
        feet_xy_B: Feet in the body frame, (N, 2) [m].
        load_n: Vertical force of the ground on each foot, (N,) [N]; 0 in the air.
        mu: Friction coefficients, (N,).
        anisotropy: w of eqn:anisotropic in body axes, (N, 2).

    Raises:
        ModelError: Shapes do not fit.
    """
    count = len(feet_xy_B)
    if load_n.shape != (count,) or mu.shape != (count,) or anisotropy.shape != (count, 2):
        raise ModelError("load and mu must be (N,) and anisotropy (N, 2) for feet (N, 2)")
    lever = np.zeros((count, 2, 3))
    lever[:, 0, 0] = lever[:, 1, 1] = 1.0
    lever[:, 0, 2], lever[:, 1, 2] = -feet_xy_B[:, 1], feet_xy_B[:, 0]
    drag = (mu * load_n)[:, None, None] * (
        np.eye(2) + anisotropy[:, :, None] * anisotropy[:, None, :]
    )
    loaded: BoolArray = load_n > 0
    if loaded.sum() < FEWEST_FEET:
        return Connection(
            np.full((3, count, 2), np.nan), drag, lever, False, "fewer than two feet are loaded"
        )
    pull = lever.transpose(0, 2, 1) @ drag  # (N, 3, 2)
    balance = np.sum(pull @ lever, axis=0)  # (3, 3)
    spread = max(float(np.abs(feet_xy_B[loaded]).max()), 1e-9)
    scale = np.array([1.0, 1.0, 1.0 / spread])
    scaled = balance * scale[:, None] * scale
    values = np.linalg.eigvalsh(scaled)
    if values[0] <= CONDITION_LIMIT * values[-1]:
        reason = "the loaded feet stand in one point: turning is not determined"
        return Connection(np.full((3, count, 2), np.nan), drag, lever, False, reason)
    flat = pull.transpose(1, 0, 2).reshape(3, -1) * scale[:, None]
    matrix = -scale[:, None] * np.linalg.solve(scaled, flat)
    return Connection(matrix.reshape(3, count, 2), drag, lever, True, "")


def solve_traction(
    feet_B: FloatArray,  # noqa: N803
    feet_velocity_B: FloatArray,  # noqa: N803
    support: Support,
    mu: FloatArray,
    anisotropy: FloatArray,
) -> Traction:
    """Body velocity, slip and foot forces of one frame.

    The ansatz knows forces up to one scale a frame. ``force_B`` is put in newtons by the scale that
    brings the horizontal forces nearest, in least squares, to Coulomb's law at the same slips; the
    balance holds for any scale. A robot at rest has no horizontal forces, not undefined ones.

    Args:
        feet_B: Feet in the body frame, (N, 3) [m].
        feet_velocity_B: Their velocities in the body frame, (N, 3) [m/s].
        support: Loads from ``solve_support``.
        mu: (N,).
        anisotropy: (N, 2).
    """
    count = len(feet_B)
    if not support.converged:
        return _none(count, f"no support: {support.reason}")
    if not np.isfinite(feet_velocity_B).all():
        return _none(count, "a foot velocity is not a number")
    load = support.load_n
    solved = connection(feet_B[:, :2], load, mu, anisotropy)
    if not solved.valid:
        return _none(count, solved.reason)
    velocity = np.einsum("aki,ki->a", solved.matrix, feet_velocity_B[:, :2])
    slip = solved.lever @ velocity + feet_velocity_B[:, :2]
    viscous = -np.einsum("kij,kj->ki", solved.drag, slip)
    force = np.column_stack([_scale(slip, viscous) * viscous, load])
    return Traction(
        valid=True,
        reason="",
        velocity_B=readonly(velocity),
        slip_B=readonly(np.where(support.contact[:, None], slip, np.nan)),
        force_B=readonly(force),
    )


def _scale(slip: FloatArray, viscous: FloatArray) -> float:
    """Scale that brings c * viscous nearest to viscous / |slip|, regularised at rest [s/m]."""
    speed = np.linalg.norm(slip, axis=1)
    power = np.sum(viscous**2, axis=1)
    total = float(power.sum())
    if total == 0.0:
        return 0.0
    return float((power / (speed + CREEP_SPEED_M_S)).sum()) / total


def _none(count: int, reason: str) -> Traction:
    return Traction(
        valid=False,
        reason=reason,
        velocity_B=readonly(np.full(3, np.nan)),
        slip_B=readonly(np.full((count, 2), np.nan)),
        force_B=readonly(np.full((count, 3), np.nan)),
    )


def solve_frame_reference(
    feet: FootMotion, contact: ContactParameters, weight_n: float
) -> ContactSolution:
    """One frame of the whole model: support, then traction."""
    support = solve_support(feet.position_m, contact.stiffness, weight_n)
    traction = solve_traction(
        feet.position_m, feet.velocity_m_s, support, contact.mu, contact.anisotropy
    )
    return ContactSolution(support, traction)
