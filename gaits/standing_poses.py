"""Poses at rest for calibrating force sensors: all legs stand, and one leg at a time is held in the air.

It is a gait like the others, so that the same mode machine, safety gate and log carry it: each step of
its phase is a move (quintic, at rest at both ends) and a time of holding still.
"""

import numpy as np

from gaits.gait import TURN, ShaftMotion
from gaits.moves import QUINTIC_PEAK, quintic
from model.values.arrays import BoolArray, FloatArray, readonly

# Share of a step that is motion; the rest is held still.
MOVING = 0.7
STEP_S = 2.4
# Feet stand within this of mid-stance, and hang within this of the top [rad].
STANCE_RAD = 0.7
AIR_RAD = 1.0
QUINTIC_BEND = 10 / np.sqrt(3)  # largest second derivative of the quintic


class StandingPoses:
    """The gait; every leg is lifted ``rounds`` times and held at ``heights`` angles each time.

    Args:
        legs: Number of legs N.
        rounds: How often each leg is lifted; its shaft makes as many turns.
        heights: Angles it is held at in the air.
        seed: The angles are drawn at random, the same for the same seed.
    """

    name = "poses"
    start_phase = 0.0

    def __init__(self, legs: int, *, rounds: int, heights: int, seed: int = 0) -> None:
        random = np.random.default_rng(seed)
        stand = random.uniform(-STANCE_RAD, STANCE_RAD, legs)
        first = stand.copy()
        turns = np.zeros(legs)
        poses: list[FloatArray] = []
        in_air: list[int] = []
        for index in range(rounds * legs):
            leg = index % legs
            poses.append(stand + turns)
            in_air.append(-1)
            cells = (np.arange(heights) + random.uniform(0.0, 1.0, heights)) / heights
            for angle in np.pi + AIR_RAD * (2 * cells - 1):
                lifted = stand + turns
                lifted[leg] = turns[leg] + angle
                poses.append(lifted)
                in_air.append(leg)
            turns[leg] += TURN
            stand = random.uniform(-STANCE_RAD, STANCE_RAD, legs)
            if index == rounds * legs - 1:
                stand = first
        poses.append(stand + turns)
        self.poses = readonly(np.array(poses))  # (S + 1, N)
        self._in_air = np.array([*in_air, -1])
        self._steps = len(poses) - 1
        self._turns = turns
        self.frequency_hz = 1.0 / (STEP_S * self._steps)

    @property
    def duration_s(self) -> float:
        """Time of the whole sequence at its own frequency [s]."""
        return 1.0 / self.frequency_hz

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N); nothing steers."""
        del steer
        cycle, step, share = self._place(phase)
        x = np.clip(share / MOVING, 0.0, 1.0)[..., None]
        change = self.poses[step + 1] - self.poses[step]
        rate = self._steps / MOVING
        done, slope = quintic(x)
        moving = (x < 1.0).astype(np.float64)
        return ShaftMotion(
            self.poses[step] + cycle[..., None] * self._turns + change * done,
            change * slope * rate * moving,
            change * (60 * x * (1 - x) * (1 - 2 * x)) * rate**2 * moving,
        )

    def _place(self, phase: FloatArray | float) -> tuple[FloatArray, np.ndarray, FloatArray]:
        phases = np.asarray(phase, dtype=np.float64)
        cycle = np.floor(phases)
        at = (phases - cycle) * self._steps
        step = np.minimum(at.astype(np.int64), self._steps - 1)
        return cycle, step, at - step

    def stance(self, phase: FloatArray | float) -> BoolArray:
        """Return which legs are to be on the ground, (..., N); one that moves counts as lifted."""
        _, step, _ = self._place(phase)
        legs = np.arange(self.poses.shape[1])
        lifted = (self._in_air[step][..., None] == legs) | (
            self._in_air[step + 1][..., None] == legs
        )
        return np.asarray(~lifted)

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and the largest curvature over a cycle."""
        del steer
        change = float(np.abs(np.diff(self.poses, axis=0)).max())
        rate = self._steps / MOVING
        return QUINTIC_PEAK * change * rate, QUINTIC_BEND * change * rate**2
