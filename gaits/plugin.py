"""A gait from a Python file: built from its text and checked; what it does not say is derived.

The file has a function ``make(legs)``, which gets the robot's ``LegParameters`` and returns an object with

    frequency_hz              cycles a second unless another number is asked for
    angle(phase, steer)       shaft angles [rad] at phases of any shape (...), as (..., N)
    stance(phase)             which legs are to be on the ground, (..., N), bool

``examples/own_gait.py`` is one. Slope, curvature, their peaks and the start phase follow from these. The
text is run as Python: build only gaits whose author you trust.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from gaits.gait import SAMPLES, TURN, ShaftMotion, middle_of_most_support
from model.errors import ConfigError
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import LegParameters, PluginParameters

NEEDED = "frequency_hz, angle(phase, steer) and stance(phase)"
FINE = 8 * SAMPLES  # of a cycle, where a gait is searched for its peaks
STEP = 0.5 / FINE  # of a difference quotient [cycles]: no corner lies between two samples unseen
AROUND = np.array([-STEP, 0.0, STEP])
STEERING = np.linspace(-1.0, 1.0, 9)
CYCLES = (1, -3, 10)  # away, where a gait must be itself again
GRID = (np.arange(360) + 0.37) / 360  # clear of phases at which legs usually touch down
STEER_GRID = np.linspace(-1.0, 1.0, 201)
HALVINGS = 32
NO_JUMP_RAD = 1e-6
SAME_RAD = 1e-9
STANCE_SLIPS = 0.02  # share of samples at which rounding may move a touchdown


class PluginGait:
    """The gait of a Python file.

    Args:
        plugin: Its name and text.
        legs: Names and places of the legs.

    Raises:
        ConfigError: The text cannot be run, or what it gives is no gait.
    """

    def __init__(self, plugin: PluginParameters, legs: LegParameters) -> None:
        self.name = plugin.name
        self._plugin, self._legs = plugin, legs
        made = self._made()
        self._angle: Callable[..., Any] = made.angle
        self._stance: Callable[..., Any] = made.stance
        self.frequency_hz = float(made.frequency_hz)
        self._check_same(self._made().angle)
        for steer in STEERING:
            self._check_periodic(float(steer))
            self._check_jumps(np.arange(FINE + 1) / FINE, float(steer))
        self._check_steering()
        self._peaks = self._searched_peaks()
        self.start_phase = middle_of_most_support(self.stance(np.arange(SAMPLES) / SAMPLES))

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        phases = np.asarray(phase, dtype=np.float64)
        cycle = np.floor(phases)
        share = phases - cycle
        before, here, after = self._angles(np.stack([share + step for step in AROUND]), steer)
        slope = (after - before) / (2 * STEP)
        curvature = (after - 2 * here + before) / STEP**2
        return ShaftMotion(here + TURN * cycle[..., None], slope, curvature)

    def stance(self, phase: FloatArray | float) -> BoolArray:
        """Return which legs are scheduled to be on the ground, (..., N)."""
        phases = np.asarray(phase, dtype=np.float64)
        down = np.asarray(self._asked(self._stance, phases))
        self._check_shape(self._stance, down, phases)
        if down.dtype != np.bool_:
            raise self._wrong(self._stance, f"stance must give true or false, not {down.dtype}")
        return down

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and curvature at any steering: how they depend on it is not known."""
        del steer
        return self._peaks

    # Asking the author's code.

    def _made(self) -> Any:
        """Run the text from the beginning and return what ``make`` gives."""
        plugin = self._plugin
        names: dict[str, Any] = {"__name__": plugin.name, "__file__": plugin.file}
        self._asked(lambda: exec(compile(plugin.text, plugin.file, "exec"), names))
        make = names.get("make")
        if not callable(make):
            raise ConfigError(plugin.file, "has no function make(legs), which returns the gait")
        made = self._asked(make, self._legs)
        for name in ("frequency_hz", "angle", "stance"):
            if not hasattr(made, name):
                words = f"what make returns has no {name}; it needs {NEEDED}"
                raise self._wrong(make, words)
        frequency = made.frequency_hz
        number = isinstance(frequency, int | float) and not isinstance(frequency, bool)
        if not number or not 0 < frequency < np.inf:
            raise self._wrong(make, f"frequency_hz must be a number above 0, not {frequency!r}")
        for name in ("angle", "stance"):
            if not callable(getattr(made, name)):
                raise self._wrong(make, f"{name} is no function; the gait needs {NEEDED}")
        return made

    def _asked(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call the author's code; whatever it raises is a mistake in the file."""
        try:
            with np.errstate(all="ignore"):
                return function(*arguments)
        except (Exception, SystemExit) as error:
            words = ": ".join(filter(None, [type(error).__name__, " ".join(str(error).split())]))
            raise ConfigError(f"{self._plugin.file}, line {self._line(error)}", words) from error

    def _line(self, error: BaseException) -> int:
        """Return the last line of the file that an error went through; the first if it is none."""
        line = error.lineno or 1 if isinstance(error, SyntaxError) else 1
        trace = error.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == self._plugin.file:
                line = trace.tb_lineno
            trace = trace.tb_next
        return line

    def _wrong(self, function: Callable[..., Any], words: str) -> ConfigError:
        """Return the error for a function of the file that does not give what it should."""
        code = getattr(function, "__code__", None)
        place = "" if code is None else f", line {code.co_firstlineno}"
        return ConfigError(f"{self._plugin.file}{place}", words)

    def _angles(self, phases: FloatArray, steer: float) -> FloatArray:
        """Ask for the shaft angles at phases of any shape (...), (..., N)."""
        try:
            angles: FloatArray = np.asarray(
                self._asked(self._angle, phases, steer), dtype=np.float64
            )
        except (TypeError, ValueError) as error:
            raise self._wrong(self._angle, f"angle must give numbers: {error}") from error
        self._check_shape(self._angle, angles, phases)
        return angles

    # Is it a gait?

    def _check_shape(
        self, function: Callable[..., Any], got: FloatArray | BoolArray, phases: FloatArray
    ) -> None:
        wanted = (*phases.shape, self._legs.count)
        if got.shape != wanted:
            raise self._wrong(
                function,
                f"phases of shape {phases.shape} must give {wanted}, one a leg, not {got.shape}",
            )

    def _check_same(self, again: Callable[..., Any]) -> None:
        """Refuse what depends on anything but phase and steering."""
        angles = self._angles(GRID, 0.3)
        if not np.isfinite(angles).all():
            at = np.argwhere(~np.isfinite(angles))[0]
            raise self._wrong(self._angle, f"angle is not finite {self._where(at[1], GRID[at[0]])}")
        single = np.stack([self._angles(np.asarray(phase), 0.3) for phase in GRID[::30]])
        fresh = np.asarray(self._asked(again, GRID, 0.3))
        same = (
            np.array_equal(angles, self._angles(GRID, 0.3))
            and np.array_equal(angles, fresh)
            and np.abs(angles[::30] - single).max() < SAME_RAD
        )
        if not same:
            raise self._wrong(
                self._angle,
                "angle gave two answers for one phase; it may depend on phase and steer only, each phase "
                "by itself",
            )

    def _check_periodic(self, steer: float) -> None:
        """Refuse a gait in which a cycle is no turn of each shaft."""
        angles, down = self._angles(GRID, steer), self.stance(GRID)
        for cycles in CYCLES:
            turned = (self._angles(GRID + cycles, steer) - angles) / cycles
            off = np.abs(turned - TURN)
            if not off.max() < NO_JUMP_RAD:
                sample, leg = np.unravel_index(int(np.argmax(off)), off.shape)
                raise self._wrong(
                    self._angle,
                    f"one cycle must turn each shaft by 2 pi, not by {turned[sample, leg]:.4f} rad "
                    + self._where(int(leg), GRID[sample]),
                )
            if (self.stance(GRID + cycles) != down).mean(axis=0).max() > STANCE_SLIPS:
                raise self._wrong(self._stance, "stance must be the same in every cycle")

    def _check_jumps(self, phases: FloatArray, steer: float) -> None:
        """Refuse angles that jump: halve the interval of the largest step until only a jump is left."""
        angles = self._angles(phases, steer)
        legs = np.arange(self._legs.count)
        first = np.abs(np.diff(angles, axis=0)).argmax(axis=0)
        low, high = phases[first], phases[first + 1]
        begin, end = angles[first, legs], angles[first + 1, legs]
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            half = self._angles(middle, steer)[legs, legs]
            upper = np.abs(end - half) > np.abs(half - begin)
            low, begin = np.where(upper, middle, low), np.where(upper, half, begin)
            high, end = np.where(upper, high, middle), np.where(upper, end, half)
        jump = np.abs(end - begin)
        if not jump.max() < NO_JUMP_RAD:
            leg = int(np.argmax(jump))
            raise self._wrong(
                self._angle, f"angle jumps by {jump[leg]:.4f} rad {self._where(leg, low[leg])}"
            )

    def _check_steering(self) -> None:
        """Refuse angles that jump with the steering: refine the largest step a hundred times."""
        phases = GRID[::10]
        angles = np.stack([self._angles(phases, float(steer)) for steer in STEER_GRID])
        steps = np.abs(np.diff(angles, axis=0))
        at = int(steps.reshape(len(steps), -1).max(axis=1).argmax())
        fine = np.linspace(STEER_GRID[at], STEER_GRID[at + 1], 101)
        finer = np.stack([self._angles(phases, float(steer)) for steer in fine])
        if not np.abs(np.diff(finer, axis=0)).max() <= max(NO_JUMP_RAD, steps.max() / 4):
            raise self._wrong(self._angle, f"angle jumps near steer {STEER_GRID[at]:.2f}")

    def _searched_peaks(self) -> tuple[float, float]:
        phases = np.arange(FINE) / FINE
        motions = [self.motion(phases, float(steer)) for steer in STEERING]
        return (
            max(float(np.abs(motion.slope).max()) for motion in motions),
            max(float(np.abs(motion.curvature).max()) for motion in motions),
        )

    def _where(self, leg: int, phase: float) -> str:
        return f"(leg {self._legs.names[leg]}, phase {phase:.4f})"
