"""The model at one frame with its derivatives, by one compiled call over stepped parameters."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from model.estimator import (
    feet_kernel as estimator_feet_kernel,
)
from model.estimator import (
    frame_kernel as estimator_kernel,
)
from model.estimator import (
    readout_kernel as estimator_readout_kernel,
)
from model.estimator import (
    step_kernel as estimator_step_kernel,
)
from model.estimator import (
    update_kernel as estimator_update_kernel,
)
from model.estimator.frame_kernel import NOT_A_NUMBER
from model.parameters.robot import ContactParameters
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import BoolArray, FloatArray
from model.values.legs import FootMotion

LOG_STEP = 0.01
SPEED_STEP_M_S = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Neighbourhood:
    """The model's answer for N feet and its derivatives; parameters are log mu, then log K.

    Attributes:
        reason: 0, or why there is no answer (``model.quasistatic.frames.Reason``); all else is then
        undefined.
        velocity_B: With sway, (3,).
        by_parameters: Its derivatives, (3, 2 N).
        by_speeds: By the feet's speeds along x, (3, N).
        sway_B: Velocity of the body origin as it tilts, (2,) [m/s].
        load_n: (N,) [N].
        load_by_stiffness: By log K, (N, N).
        pose: slope_x, slope_y, height, (3,).
        pose_by_stiffness: (3, N).
        slip_B: (N, 2) [m/s].
        force_B: Horizontal forces, (N, 2) [N].
        force_by_parameters: (N, 2, 2 N).
        resting: Feet at rest, (N,).
    """

    reason: int
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    by_parameters: FloatArray
    by_speeds: FloatArray
    sway_B: FloatArray  # noqa: N815
    load_n: FloatArray
    load_by_stiffness: FloatArray
    pose: FloatArray
    pose_by_stiffness: FloatArray
    slip_B: FloatArray  # noqa: N815
    force_B: FloatArray  # noqa: N815
    force_by_parameters: FloatArray
    resting: BoolArray


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    estimator_kernel.prepare()
    estimator_step_kernel.prepare()
    estimator_update_kernel.prepare()
    estimator_readout_kernel.prepare()
    estimator_feet_kernel.prepare()


@cache
def no_answer(count: int) -> Neighbourhood:
    """All NaN, for N feet: what is said where the model says nothing."""
    row, square = np.full(count, np.nan), np.full((count, count), np.nan)
    plane, space = np.full((count, 2), np.nan), np.full(3, np.nan)
    by_three, by_both = np.full((3, count), np.nan), np.full((3, 2 * count), np.nan)
    of_forces = np.full((count, 2, 2 * count), np.nan)
    return Neighbourhood(
        reason=NOT_A_NUMBER,
        velocity_B=space,
        by_parameters=by_both,
        by_speeds=by_three,
        sway_B=np.full(2, np.nan),
        load_n=row,
        load_by_stiffness=square,
        pose=space,
        pose_by_stiffness=by_three,
        slip_B=plane,
        force_B=plane,
        force_by_parameters=of_forces,
        resting=np.zeros(count, dtype=np.bool_),
    )


def neighbourhood(
    feet: FootMotion,
    contact: ContactParameters,
    weight_n: float,
    law: FrictionLaw,
    sway_step_s: float,
    rest_speed: float = 0.0,
) -> Neighbourhood:
    """Solve a frame and step each parameter and foot speed by a little.

    Args:
        feet: (N, 3) each, all finite.
        contact: Stiffness and friction to solve at.
        weight_n: Weight carried [N].
        law: Friction law. The viscous ansatz' forces get the scale that brings them nearest to
            Coulomb's law at the same slips.
        sway_step_s: Time either way over which slopes are differenced [s]; 0 leaves sway out.
        rest_speed: Root mean square slip at which half of Coulomb's forces are taken from the ansatz, for
            more the more slowly the feet slip [m/s]; 0 asks Coulomb's law alone wherever it has an answer.
    """
    count = len(contact.mu)
    velocity = np.empty((1 + 3 * count, 3))
    loads = np.empty((1 + count, count))
    pose = np.empty((1 + count, 3))
    sway = np.zeros(2)
    slip = np.zeros((count, 2))
    force = np.zeros((1 + 2 * count, count, 2))
    resting = np.zeros(count, dtype=np.bool_)
    reason = estimator_kernel.neighbourhood_kernel(
        np.ascontiguousarray(feet.position_m),
        np.ascontiguousarray(feet.velocity_m_s),
        contact.stiffness,
        contact.mu,
        contact.anisotropy,
        weight_n,
        law is FrictionLaw.COULOMB,
        sway_step_s,
        LOG_STEP,
        SPEED_STEP_M_S,
        rest_speed,
        velocity,
        loads,
        pose,
        sway,
        slip,
        force,
        resting,
    )
    if law is FrictionLaw.VISCOUS and reason == 0:
        force *= _scale(force[0], slip)
    by_parameters = np.empty((3, 2 * count))
    by_speeds = np.empty((3, count))
    load_by_stiffness = np.empty((count, count))
    pose_by_stiffness = np.empty((3, count))
    force_by_parameters = np.empty((count, 2, 2 * count))
    estimator_step_kernel.slopes_kernel(
        velocity,
        loads,
        pose,
        force,
        LOG_STEP,
        SPEED_STEP_M_S,
        by_parameters,
        by_speeds,
        load_by_stiffness,
        pose_by_stiffness,
        force_by_parameters,
    )
    return Neighbourhood(
        reason=int(reason),
        velocity_B=velocity[0],
        by_parameters=by_parameters,
        by_speeds=by_speeds,
        sway_B=sway,
        load_n=loads[0],
        load_by_stiffness=load_by_stiffness,
        pose=pose[0],
        pose_by_stiffness=pose_by_stiffness,
        slip_B=slip,
        force_B=force[0],
        force_by_parameters=force_by_parameters,
        resting=resting,
    )


def _scale(force: FloatArray, slip: FloatArray) -> float:
    square = np.einsum("ki,ki->k", force, force)
    power = float(square.sum())
    aim = float(
        (
            square / (np.sqrt(np.einsum("ki,ki->k", slip, slip)) + estimator_kernel.CREEP_SPEED_M_S)
        ).sum()
    )
    return aim / power if power > 0 else 0.0
