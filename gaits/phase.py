"""Phase and steering as functions of time: anchored to a time stamp, never to a count of ticks."""

from dataclasses import dataclass


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

    def value(self, t_ns: int) -> float:
        """Return the level at a time."""
        return self.begin + self.slope(self.t_ns) * min(self._elapsed_s(t_ns), self.duration_s)

    def slope(self, t_ns: int) -> float:
        """Return the change a second at a time; 0 once the end is reached."""
        if self.end == self.begin or self._elapsed_s(t_ns) >= self.duration_s:
            return 0.0
        return self.rate if self.end > self.begin else -self.rate

    def integral(self, t_ns: int) -> float:
        """Return the integral over time from the beginning [level s]."""
        elapsed = self._elapsed_s(t_ns)
        ramping = min(elapsed, self.duration_s)
        slope = self.slope(self.t_ns)
        return self.begin * ramping + slope * ramping**2 / 2 + self.end * (elapsed - ramping)

    def done(self, t_ns: int) -> bool:
        """Whether the end is reached."""
        return self._elapsed_s(t_ns) >= self.duration_s


@dataclass(frozen=True, slots=True)
class GaitClock:
    """Phase of a gait: the integral of a ramped frequency.

    Attributes:
        phase: Phase at the beginning of the ramp [cycles].
        frequency: Frequency [Hz].
    """

    phase: float
    frequency: Ramp

    def phase_at(self, t_ns: int) -> float:
        """Return the phase [cycles]."""
        return self.phase + self.frequency.integral(t_ns)

    def frequency_at(self, t_ns: int) -> float:
        """Return the frequency [Hz]."""
        return self.frequency.value(t_ns)

    def retuned(self, t_ns: int, frequency_hz: float) -> "GaitClock":
        """Return a clock that ramps to another frequency from here on, without a jump."""
        if frequency_hz == self.frequency.end:
            return self
        ramp = Ramp(t_ns, self.frequency_at(t_ns), frequency_hz, self.frequency.rate)
        return GaitClock(self.phase_at(t_ns), ramp)
