"""What lies between the goal a servo was sent and the goal its control loop follows.

Nothing in a healthy servo. Switched on: goals that act late, set points that lag or are too slow, goals
that are missed for a while. All in ticks, in the servo's own sense.
"""

import numpy as np

from drivers.dynamixel.units import TICK_RAD
from model.values.arrays import FloatArray
from sim_hw.plant.parameters import DriveParameters


class GoalPath:
    """Goals of all servos between bus and control loops.

    Args:
        drive: Delay, lag, speed limit, missed goals.
        start_ticks: Where the shafts are, (N,).
        dt_s: Step.
        seed: Of the missed goals.
    """

    def __init__(
        self, drive: DriveParameters, start_ticks: FloatArray, dt_s: float, seed: int
    ) -> None:
        count = len(start_ticks)
        self._line = np.tile(start_ticks, (round(drive.delay_s / dt_s) + 1, 1))
        self._at = 0
        self._gain = np.where(
            drive.lag_s > 0, -np.expm1(-dt_s / np.maximum(drive.lag_s, 1e-9)), 1.0
        )
        self._most = drive.speed_limit / TICK_RAD * dt_s
        self._miss = drive.hold_rate * dt_s
        self._miss_steps = round(drive.hold_s / dt_s)
        self._missing = np.zeros(count, dtype=np.int64)
        self._random = np.random.default_rng([seed, 0x68])
        self._point = start_ticks.copy()
        self._goal = start_ticks.copy()

    @staticmethod
    def needed(drive: DriveParameters) -> bool:
        """Whether goals are anything but followed at once."""
        return bool(
            drive.delay_s > 0
            or (drive.lag_s > 0).any()
            or np.isfinite(drive.speed_limit).any()
            or (drive.hold_rate > 0).any()
        )

    def restart(self, index: int, ticks: float) -> None:
        """A servo's torque comes on: it holds where it is."""
        self._line[:, index] = self._point[index] = self._goal[index] = ticks

    def advance(self, goal: FloatArray) -> FloatArray:
        """Take the goals of this step, return what the loops follow, (N,)."""
        self._line[self._at] = goal
        self._at = (self._at + 1) % len(self._line)
        late = self._line[self._at]  # the oldest, or the newest where the line holds one
        if self._miss.any():
            begins = self._random.random(len(goal)) < self._miss
            self._missing = np.where(begins, self._miss_steps, np.maximum(self._missing - 1, 0))
            late = np.where(self._missing > 0, self._goal, late)
        self._goal = late.copy()
        step = np.clip((self._goal - self._point) * self._gain, -self._most, self._most)
        self._point = self._point + step
        return self._point
