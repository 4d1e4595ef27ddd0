"""One frame of the chain, for the control loop: measured shafts in, support and friction out.

A robot file with effects is used online, too. The chain's own stages are run on three frames a
millisecond apart, with the shafts at their speeds, and the middle one is the answer: so an effect means
the same to a diagnosis and to the controller. What must be remembered from tick to tick (the pose for
effects that are bound to a place, the velocity that lags) is given by whoever calls.
"""

from dataclasses import dataclass

import numpy as np

from model.effects.grid import Grid
from model.effects.ground import Sliding, Standing, contact_points, foot_slip, slide, stand
from model.effects.machine import LeggedMachine
from model.effects.pushes import Before, Scene
from model.effects.sensing import true_forces
from model.effects.settings import Settings, settings_of
from model.effects.shafts import feet
from model.motion.se2 import turned
from model.values.arrays import FloatArray, readonly
from model.values.contact import ContactSolution, Support, Traction, no_contact
from model.values.legs import FootForces, FootMotion

PERIOD_S = 1e-3
AROUND_S = np.array([-PERIOD_S, 0.0, PERIOD_S])
MIDDLE = 1
NO_SUPPORT = "the feet cannot carry the robot, or an angle is not known"
SPEED_UNKNOWN = "a shaft's speed is not known"
TOO_FEW = "fewer than two feet are loaded"


class _Moment(Grid):
    """Three frames; slopes are central differences, whatever window is asked for."""

    def window(self, seconds: float) -> int:
        """Return all three frames."""
        del seconds
        return len(AROUND_S)


@dataclass(frozen=True, slots=True, eq=False)
class FrameAnswer:
    """The model of one frame: unloaded feet as the robot file with its effects has them, and contact."""

    feet: FootMotion
    contact: ContactSolution


class FrameModel:
    """The model of a robot file with effects, frame by frame."""

    def __init__(self, machine: LeggedMachine) -> None:
        self._machine = machine
        self._grid = _Moment(0.0, PERIOD_S, len(AROUND_S), PERIOD_S)
        self.settings = settings_of(machine.effects, machine.names, machine.size)
        self._ratio = self.settings.each("encoder_scale")[0]

    def prepare(self) -> None:
        """Load or make the machine code now, so that no tick has to wait for it."""
        still = np.zeros(len(self._ratio))
        self.solve(still, still, np.zeros(3), np.full(3, np.nan), 0.0)

    def solve(
        self,
        angle_rad: FloatArray,
        rate_rad_s: FloatArray,
        pose: FloatArray,
        before: FloatArray,
        dt_s: float,
    ) -> FrameAnswer:
        """Solve a frame.

        Args:
            angle_rad: Shafts as their encoders have them, (J,); NaN where unknown.
            rate_rad_s: Their speeds, (J,).
            pose: x, y [m], yaw [rad] since the run began, (3,).
            before: Body velocity of the frame before, (3,); NaN if there was none.
            dt_s: Time since then.
        """
        angle, rate = angle_rad / self._ratio, rate_rad_s / self._ratio
        moving = bool(np.isfinite(rate).all())  # not in the first ticks
        shafts = angle + AROUND_S[:, None] * (rate if moving else 0.0)
        settings = self._turned(float(pose[2]))
        world = np.tile(pose, (len(AROUND_S), 1))
        walked = feet(self._machine, self._grid, shafts, settings)
        points = contact_points(walked, settings)
        velocity = (points[2] - points[0]) / (2 * PERIOD_S) + (0.0 if moving else np.nan)
        if len(walked.rolling_m_s) == len(points):
            velocity[:, :2] += walked.rolling_m_s[MIDDLE]
        motion = FootMotion(readonly(points[MIDDLE].copy()), readonly(velocity))
        if not (np.isfinite(points).all() and np.isfinite(world).all()):
            return FrameAnswer(motion, no_contact(self._machine.legs.count, NO_SUPPORT))
        moved = np.tile(before, (len(AROUND_S), 1)) if np.isfinite(before).all() else None
        scene = Scene(self._machine, self._grid, settings, world)
        standing = stand(scene, walked, moved)
        if not np.isfinite(standing.load_n).all():
            return FrameAnswer(motion, no_contact(self._machine.legs.count, NO_SUPPORT))
        kept = Before(before, dt_s) if dt_s > 0 else None
        sliding = slide(scene, walked, standing, standing.load_n, before=kept)
        return FrameAnswer(motion, _contact(motion, standing, sliding))

    def true_forces(self, forces: FootForces, since_s: float) -> FootForces:
        """Take gain, bias, drift and rotation of the transducers out of a reading.

        Args:
            forces: As the calibrated sensors report them.
            since_s: Time since the run began, for drifts.
        """
        force_n = true_forces(forces.force_n, since_s, self.settings)
        return FootForces(forces.t_ns, readonly(force_n), forces.valid)

    def _turned(self, yaw: float) -> Settings:
        """Settings with the ground's slope as the body meets it, turned by yaw since the run began."""
        if not self.settings.has("ground_slope"):
            return self.settings
        slope_x, slope_y = self.settings.whole("ground_slope")
        return self.settings.with_whole("ground_slope", *turned(slope_x, slope_y, -yaw))


def _contact(motion: FootMotion, standing: Standing, sliding: Sliding) -> ContactSolution:
    """Support and traction of the middle frame; NaN, and why, where there is no velocity."""
    load = readonly(standing.load_n[MIDDLE].copy())
    loaded = readonly(load > 0.0)
    slope_x, slope_y = standing.slopes[MIDDLE].tolist()
    height = float(standing.height_m[MIDDLE])
    support = Support(True, "", height, slope_x, slope_y, load, loaded, 0)
    velocity = sliding.velocity_B[MIDDLE].copy()
    if not np.isfinite(motion.velocity_m_s).all():
        return ContactSolution(support, no_contact(len(load), SPEED_UNKNOWN).traction)
    if not np.isfinite(velocity).all():
        return ContactSolution(support, no_contact(len(load), TOO_FEW).traction)
    slip = foot_slip(motion.position_m, motion.velocity_m_s, velocity)
    slip[~loaded] = np.nan
    force = np.column_stack([sliding.force_xy_n[MIDDLE], load])
    traction = Traction(True, "", readonly(velocity), readonly(slip), readonly(force))
    return ContactSolution(support, traction)
