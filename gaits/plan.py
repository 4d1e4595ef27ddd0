"""Plans: shaft angle and speed of every leg as a function of time. Frozen values, pure functions.

The controller holds one plan at a time: ``Hold`` still, ``LegMoves`` one leg after the other, or
``Walking``. Gait-to-gait transitions are composed of them: slow to a stop, move to the other gait's
start pose leg by leg, speed up. Angles never jump across any of these.
"""

from dataclasses import dataclass, replace

import numpy as np

from gaits.gait import TURN, Gait
from gaits.moves import LegMoves
from gaits.phase import GaitClock, Ramp
from model.values.arrays import FloatArray

FREQUENCY_RAMP_HZ_S = 0.2
STEER_RAMP_S = 0.5
_STEER_STEP = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Hold:
    """Stand still at these shaft angles, (N,) [rad]."""

    angle_rad: FloatArray

    def at(self, _t_ns: int) -> tuple[FloatArray, FloatArray]:
        """Return shaft angles [rad] and speeds [rad/s], (N,) each."""
        return self.angle_rad, np.zeros_like(self.angle_rad)


@dataclass(frozen=True, slots=True, eq=False)
class Walking:
    """Follow a gait.

    Attributes:
        gait: The gait.
        clock: Its phase.
        steer: Its steering, -1 (right) to 1 (left).
        turns_rad: Whole turns added to each shaft so that the plan begins where the legs are, (N,).
    """

    gait: Gait
    clock: GaitClock
    steer: Ramp
    turns_rad: FloatArray

    @staticmethod
    def begin(t_ns: int, gait: Gait, angle_rad: FloatArray, frequency_hz: float) -> "Walking":
        """Begin at the gait's start pose, at rest, going straight.

        Args:
            t_ns: Now.
            gait: The gait.
            angle_rad: Shaft angles now: the start pose up to whole turns, (N,).
            frequency_hz: Frequency to ramp up to.
        """
        start = gait.motion(gait.start_phase, 0.0).angle_rad
        turns = TURN * np.rint((angle_rad - start) / TURN)
        clock = GaitClock(gait.start_phase, Ramp(t_ns, 0.0, frequency_hz, FREQUENCY_RAMP_HZ_S))
        return Walking(gait, clock, Ramp(t_ns, 0.0, 0.0, STEER_RAMP_S), turns)

    def phase(self, t_ns: int) -> float:
        """Return the gait phase [cycles]."""
        return self.clock.phase_at(t_ns)

    def at(self, t_ns: int) -> tuple[FloatArray, FloatArray]:
        """Return shaft angles [rad] and speeds [rad/s], (N,) each."""
        phase, steer = self.phase(t_ns), self.steer.value(t_ns)
        motion = self.gait.motion(phase, steer)
        rate = motion.slope * self.clock.frequency_at(t_ns)
        steering = self.steer.slope(t_ns)
        if steering != 0.0:
            further = self.gait.motion(phase, steer + _STEER_STEP).angle_rad
            rate = rate + (further - motion.angle_rad) / _STEER_STEP * steering
        return motion.angle_rad + self.turns_rad, rate

    def retuned(self, t_ns: int, frequency_hz: float) -> "Walking":
        """Return the plan with another frequency, ramped."""
        return replace(self, clock=self.clock.retuned(t_ns, frequency_hz))

    def steered(self, t_ns: int, steer: float) -> "Walking":
        """Return the plan with another steering, ramped."""
        if steer == self.steer.end:
            return self
        return replace(self, steer=Ramp(t_ns, self.steer.value(t_ns), steer, STEER_RAMP_S))

    def slowing(self, t_ns: int) -> "Walking":
        """Return the plan coming to a stop where it is; the steering stays as it stands."""
        value = self.steer.value(t_ns)
        still = Ramp(t_ns, value, value, STEER_RAMP_S)
        return replace(self.retuned(t_ns, 0.0), steer=still)

    def stopped(self, t_ns: int) -> bool:
        """Whether the plan has come to a stop."""
        return self.clock.frequency.end == 0.0 and self.clock.frequency.done(t_ns)


Plan = Hold | LegMoves | Walking
