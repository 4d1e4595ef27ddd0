"""The Buehler clock: slow stance, fast return; each leg with its own delay, duty and sweep.

Source: Saranli, Buehler, Koditschek, "RHex: a simple and highly mobile hexapod robot", 2001,
doi 10.1177/02783640122067570.

The clock is piecewise linear: its speed jumps at touchdown and lift-off, which no servo can follow.
Each corner is therefore rounded by a parabola over a share ``blend`` of the period; ``blend = 0``
gives the classical clock, whose acceleration has no limit and which ``gaits.limits`` refuses.
"""

from functools import lru_cache
from math import floor, isfinite

import numpy as np

from gaits.gait import TURN, DelayedLegs, ShaftMotion
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import BuehlerParameters, LegParameters


class BuehlerClock(DelayedLegs):
    """Legs that turn at one speed in stance and at another in the return.

    Args:
        parameters: Touchdowns, duties, sweeps, offsets and the blend.
        legs: Names and sides of the legs.

    Raises:
        ConfigError: The blends would overlap, or full steering would sweep a whole turn.
    """

    def __init__(self, parameters: BuehlerParameters, legs: LegParameters) -> None:
        shortest = float(np.minimum(parameters.duty, 1 - parameters.duty).min())
        if parameters.blend > shortest:
            raise ConfigError(
                f"gait.{parameters.name}.blend",
                f"{parameters.blend:g} is longer than the shorter part of the period, {shortest:g}",
            )
        super().__init__(parameters, legs)
        self._parameters = parameters
        self._speeds = lru_cache(maxsize=4)(self._speeds_at)
        self._numbers = lru_cache(maxsize=4)(self._numbers_at)

    def _speeds_at(self, steer: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sweep of each leg in stance [rad], its slow and its fast slope [rad a cycle], (N,) each."""
        p, sweep = self._parameters, self.sweeps(steer)
        return sweep, sweep / p.duty, (TURN - sweep) / (1 - p.duty)

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        p = self._parameters
        sweep, slow, fast = self._speeds(steer)
        leg_phase = self.leg_phase(phase)
        if leg_phase.ndim == 1 and isfinite(phase):
            return self._motion_now(leg_phase, steer)
        cycle = np.floor(leg_phase)
        x = leg_phase - cycle  # share of the leg's own period, touchdown at 0
        beyond = x - p.duty
        in_stance = x < p.duty
        angle = np.where(in_stance, slow * x, sweep + fast * beyond)
        slope = np.where(in_stance, slow, fast) + 0.0 * x
        curvature = np.zeros_like(angle)
        # where each lies, slopes before and after, and the angle there
        corners: tuple[tuple[FloatArray | float, FloatArray, FloatArray, FloatArray | float], ...]
        corners = ((p.duty, slow, fast, sweep), (0.0, fast, slow, 0.0), (1.0, fast, slow, TURN))
        nearest = np.minimum(np.abs(beyond), np.minimum(x, 1.0 - x))
        if not nearest.min() < p.blend / 2:  # most of the time: nothing to round
            corners = ()
        for corner, before, after, at_corner in corners:
            near = np.abs(x - corner) < p.blend / 2
            if near.any():
                y = x - corner + p.blend / 2  # from the beginning of the blend
                bend = (after - before) / p.blend
                rounded = at_corner + before * (x - corner) + bend * y**2 / 2
                angle = np.where(near, rounded, angle)
                slope = np.where(near, before + bend * y, slope)
                curvature = np.where(near, bend, curvature)
        return ShaftMotion(angle + TURN * cycle + p.offset - sweep / 2, slope, curvature)

    def _numbers_at(self, steer: float) -> list[tuple[float, ...]]:
        """Slopes, sweep, duty and offset of each leg as plain numbers."""
        p = self._parameters
        sweep, slow, fast = self._speeds(steer)
        return list(
            zip(*(one.tolist() for one in (slow, fast, sweep, p.duty, p.offset)), strict=True)
        )

    def _motion_now(self, leg_phase: FloatArray, steer: float) -> ShaftMotion:
        """``motion`` at one phase, to the bit: a few legs are sooner done one by one than as arrays."""
        blend = self._parameters.blend
        motions = []
        for at, (slow, fast, sweep, duty, offset) in zip(
            leg_phase.tolist(), self._numbers(steer), strict=True
        ):
            cycle = float(floor(at))
            x = at - cycle
            beyond = x - duty
            angle, slope, curvature = slow * x, slow, 0.0
            if not x < duty:
                angle, slope = sweep + fast * beyond, fast
            if min(abs(beyond), x, 1.0 - x) < blend / 2:
                corners = (
                    (duty, slow, fast, sweep),
                    (0.0, fast, slow, 0.0),
                    (1.0, fast, slow, TURN),
                )
                for corner, before, after, at_corner in corners:
                    if abs(x - corner) < blend / 2:
                        y = x - corner + blend / 2
                        bend = (after - before) / blend
                        angle = at_corner + before * (x - corner) + bend * (y * y) / 2
                        slope, curvature = before + bend * y, bend
            motions.append((angle + TURN * cycle + offset - sweep / 2, slope, curvature))
        angles, slopes, curvatures = np.array(motions).T
        return ShaftMotion(
            np.ascontiguousarray(angles),
            np.ascontiguousarray(slopes),
            np.ascontiguousarray(curvatures),
        )

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and curvature; the curvature is infinite without blends."""
        p = self._parameters
        _, slow, fast = self._speeds(steer)
        jump = float(np.abs(fast - slow).max())
        bend = jump / p.blend if p.blend > 0 else (np.inf if jump > 0 else 0.0)
        return float(np.maximum(slow, fast).max()), bend
