"""Run a system through the model: every frame's answer, velocity and path of the body."""

from dataclasses import dataclass

import numpy as np

from model.motion.low_pass import low_pass
from model.motion.se2 import integrate
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.systems.system import System
from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SystemPrediction:
    """What the model says of a system.

    Attributes:
        system: The system.
        law: Friction law used.
        solutions: Answer of each frame.
        velocity_B: Body velocity after the system's low pass, (F, 3) [m/s], [rad/s]; NaN where a
            frame has no answer.
        poses: x, y [m], yaw [rad] at each frame and after the last, from (0, 0, 0), (F + 1, 3). The
            body rests where a frame has no answer.
    """

    system: System
    law: FrictionLaw
    solutions: FrameSolutions
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    poses: FloatArray

    def __repr__(self) -> str:
        """Return a line about it, without the arrays."""
        forward_m, sideways_m, yaw_rad = self.poses[-1]
        return (
            f"SystemPrediction of {self.system.description}, {self.law.value}: "
            f"{self.solutions.valid.sum()} of {self.system.frames} frames have an answer; "
            f"{forward_m:.3f} m forward, {sideways_m:.3f} m to the left, {yaw_rad:.3f} rad turned"
        )


def predict(
    system: System, *, law: FrictionLaw = FrictionLaw.VISCOUS, tilt_coupling: bool = False
) -> SystemPrediction:
    """Predict loads, velocity and trajectory of a system.

    Args:
        system: The system.
        law: Friction law.
        tilt_coupling: As in ``solve_frames``.

    Raises:
        ModelError: The system cannot be solved at all (shapes).
    """
    solutions = solve_frames(
        system.feet,
        system.contact,
        system.weight_n,
        law=law,
        tilt_coupling=tilt_coupling,
        ground_m=system.ground_m,
        anisotropy_B=system.anisotropy_B,
    )
    velocity = np.where(solutions.valid[:, None], solutions.velocity_B, np.nan)
    if system.low_pass is not None:
        velocity = low_pass(velocity, system.low_pass)
    poses = integrate(np.where(np.isfinite(velocity), velocity, 0.0), system.step_s)
    return SystemPrediction(system, law, solutions, velocity, poses)
