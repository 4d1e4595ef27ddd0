"""Plans: shaft angle and speed of every leg as a function of time. Frozen values, pure functions.

The controller holds one plan at a time: ``Hold`` still, ``LegMoves`` one leg after the other, or
``Walking``. Gait-to-gait transitions are composed of them: slow to a stop, move to the other gait's
start pose leg by leg, speed up. Angles never jump across any of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gaits.buehler import BuehlerClock
from gaits.gait import TURN, Gait
from gaits.moves import LegMoves
from model.values.arrays import FloatArray, readonly

FREQUENCY_RAMP_HZ_S = 0.2
STEER_RAMP_PER_S = 0.5
_STEER_STEP = 1e-6


@dataclass(frozen=True, slots=True)
class Ramp:
    """A value that goes at a steady rate from one level to another and stays there.

    Attributes:
        t_ns: When it begins.
        begin: Level at ``t_ns``.
        end: Level it goes to.
        rate: Change a second, positive.
    """

    t_ns: int
    begin: float
    end: float
    rate: float

    @property
    def duration_s(self) -> float:
        """Seconds it takes."""
        return abs(self.end - self.begin) / self.rate

    def _elapsed_s(self, t_ns: int) -> float:
        return max(0, t_ns - self.t_ns) * 1e-9

    def _at_first(self) -> tuple[float, float]:
        """Return how long it takes [s], and the change a second at the beginning."""
        duration_s = self.duration_s
        if duration_s <= 0.0:
            return duration_s, 0.0
        return duration_s, self.rate if self.end > self.begin else -self.rate

    def value(self, t_ns: int) -> float:
        """Return the level at a time."""
        duration_s, slope = self._at_first()
        return self.begin + slope * min(self._elapsed_s(t_ns), duration_s)

    def slope(self, t_ns: int) -> float:
        """Return the change a second at a time; 0 once the end is reached."""
        duration_s, slope = self._at_first()
        return 0.0 if self._elapsed_s(t_ns) >= duration_s else slope

    def integral(self, t_ns: int) -> float:
        """Return the integral over time from the beginning [level s]."""
        elapsed, (duration_s, slope) = self._elapsed_s(t_ns), self._at_first()
        ramping = min(elapsed, duration_s)
        return self.begin * ramping + slope * ramping**2 / 2 + self.end * (elapsed - ramping)

    def done(self, t_ns: int) -> bool:
        """Whether the end is reached."""
        return self._elapsed_s(t_ns) >= self.duration_s

    def to(self, t_ns: int, end: float) -> "Ramp":
        """Return a ramp to another level from here on, at the same rate and without a jump."""
        return Ramp(t_ns, self.value(t_ns), end, self.rate)


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
        begin_phase: Phase at the beginning of the frequency's ramp [cycles]. Phase is anchored to that time
            stamp, never to a count of ticks.
        frequency: Cycles a second, whose integral is the phase [Hz].
        steer: Its steering, -1 (right) to 1 (left).
        turns_rad: Whole turns added to each shaft so that the plan begins where the legs are, (N,).
    """

    gait: Gait
    begin_phase: float
    frequency: Ramp
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
        frequency = Ramp(t_ns, 0.0, frequency_hz, FREQUENCY_RAMP_HZ_S)
        straight = Ramp(t_ns, 0.0, 0.0, STEER_RAMP_PER_S)
        return Walking(gait, gait.start_phase, frequency, straight, turns)

    def phase(self, t_ns: int) -> float:
        """Return the gait phase [cycles]."""
        return self.begin_phase + self.frequency.integral(t_ns)

    def at(self, t_ns: int) -> tuple[FloatArray, FloatArray]:
        """Return shaft angles [rad] and speeds [rad/s], (N,) each."""
        phase, steer = self.phase(t_ns), self.steer.value(t_ns)
        motion = self.gait.motion(phase, steer)
        rate = motion.slope * self.frequency.value(t_ns)
        steering = self.steer.slope(t_ns)
        if steering != 0.0:
            further = self.gait.motion(phase, steer + _STEER_STEP).angle_rad
            rate = rate + (further - motion.angle_rad) / _STEER_STEP * steering
        return motion.angle_rad + self.turns_rad, rate

    def rows(self, times_ns: Sequence[int]) -> "GoalRows":
        """Return ``phase`` and ``at`` of many times in order, the same numbers.

        Args:
            times_ns: The times, at least one.
        """
        phases = [self.phase(t_ns) for t_ns in times_ns]
        if isinstance(self.gait, BuehlerClock) and self.steer.done(times_ns[0]):
            # steering is over, and one compiled call is all that makes the motion
            motion = self.gait.motion(np.array(phases), self.steer.value(times_ns[0]))
            frequencies = np.array([self.frequency.value(t_ns) for t_ns in times_ns])
            angle_rad = motion.angle_rad + self.turns_rad
            rate_rad_s = motion.slope * frequencies[:, None]
        else:
            angles, rates = zip(*map(self.at, times_ns), strict=True)
            angle_rad, rate_rad_s = np.array(angles), np.array(rates)
        return GoalRows(np.array(phases), readonly(angle_rad), readonly(rate_rad_s))

    def retuned(self, t_ns: int, frequency_hz: float) -> "Walking":
        """Return the plan with another frequency, ramped."""
        if frequency_hz == self.frequency.end:
            return self
        ramp = self.frequency.to(t_ns, frequency_hz)
        return replace(self, begin_phase=self.phase(t_ns), frequency=ramp)

    def steered(self, t_ns: int, steer: float) -> "Walking":
        """Return the plan with another steering, ramped."""
        if steer == self.steer.end:
            return self
        return replace(self, steer=self.steer.to(t_ns, steer))

    def slowing(self, t_ns: int) -> "Walking":
        """Return the plan coming to a stop where it is; the steering stays as it stands."""
        still = self.steer.to(t_ns, self.steer.value(t_ns))
        return replace(self.retuned(t_ns, 0.0), steer=still)

    def stopped(self, t_ns: int) -> bool:
        """Whether the plan has come to a stop."""
        return self.frequency.end == 0.0 and self.frequency.done(t_ns)


@dataclass(frozen=True, slots=True, eq=False)
class GoalRows:
    """What a plan wants at T times.

    Attributes:
        phase: Of the gait [cycles], (T,).
        angle_rad: Shaft angles, (T, N).
        rate_rad_s: Their speeds, (T, N).
    """

    phase: FloatArray
    angle_rad: FloatArray
    rate_rad_s: FloatArray


Plan = Hold | LegMoves | Walking
