"""The Buehler clock: slow stance, fast return; each leg with its own delay, duty and sweep.

Source: Saranli, Buehler, Koditschek, "RHex: a simple and highly mobile hexapod robot", 2001,
doi 10.1177/02783640122067570.

The clock is piecewise linear: its speed jumps at touchdown and lift-off, which no servo can follow.
Each corner is therefore rounded by a parabola over a share ``blend`` of the period; ``blend = 0``
gives the classical clock, whose acceleration has no limit and which ``gaits.limits`` refuses.
"""

from functools import lru_cache

import numpy as np

from gaits.gait import TURN, DelayedLegs, ShaftMotion
from model.compiled import NUMBER, compile_for, compiled, given, in_place, out
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import BuehlerParameters, LegParameters


@in_place
@compiled
def buehler_motion(
    leg_phase: FloatArray,
    duty: FloatArray,
    offset: FloatArray,
    sweep: FloatArray,
    slow: FloatArray,
    fast: FloatArray,
    blend: float,
    motion: FloatArray,
) -> None:
    """Write the motion of all legs at some phases.

    Args:
        leg_phase: Phase of each leg, touchdown at whole numbers, (M, N) [cycles].
        duty: Share of the period in stance, (N,).
        offset: Angle in mid-stance, (N,) [rad].
        sweep: Sweep in stance, (N,) [rad].
        slow: Slope in stance, (N,) [rad a cycle].
        fast: Slope in the return, (N,) [rad a cycle].
        blend: Share of the period over which a corner is rounded.
        motion: Angle, slope and curvature, (3, M, N); written.
    """
    for i in range(leg_phase.shape[0]):
        for k in range(leg_phase.shape[1]):
            cycle = np.floor(leg_phase[i, k])
            x = leg_phase[i, k] - cycle  # share of the leg's own period, touchdown at 0
            if x < duty[k]:
                angle, slope = slow[k] * x, slow[k]
            else:
                angle, slope = sweep[k] + fast[k] * (x - duty[k]), fast[k]
            curvature = 0.0
            for corner in range(3):  # lift-off, touchdown, the next one
                if corner == 0:
                    at, before, after, at_corner = duty[k], slow[k], fast[k], sweep[k]
                else:
                    at, at_corner = (0.0, 0.0) if corner == 1 else (1.0, TURN)
                    before, after = fast[k], slow[k]
                if abs(x - at) < blend / 2:
                    y = x - at + blend / 2  # from the beginning of the blend
                    curvature = (after - before) / blend
                    angle = at_corner + before * (x - at) + curvature * (y * y) / 2
                    slope = before + curvature * y
            motion[0, i, k] = angle + TURN * cycle + offset[k] - sweep[k] / 2
            motion[1, i, k] = slope
            motion[2, i, k] = curvature


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
        self._duty_and_offset = (
            np.ascontiguousarray(parameters.duty, dtype=np.float64),
            np.ascontiguousarray(parameters.offset, dtype=np.float64),
        )

    def _speeds_at(self, steer: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sweep of each leg in stance [rad], its slow and its fast slope [rad a cycle], (N,) each."""
        p, sweep = self._parameters, self.sweeps(steer)
        return sweep, sweep / p.duty, (TURN - sweep) / (1 - p.duty)

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        sweep, slow, fast = self._speeds(steer)
        leg_phase = np.ascontiguousarray(self.leg_phase(phase))
        duty, offset = self._duty_and_offset
        if leg_phase.ndim == 1:  # of a tick: nothing to be laid flat
            row = np.empty((3, 1, len(sweep)))
            buehler_motion(
                leg_phase[None], duty, offset, sweep, slow, fast, self._parameters.blend, row
            )
            return ShaftMotion(row[0, 0], row[1, 0], row[2, 0])
        motion = np.empty((3, *leg_phase.shape))
        flat = leg_phase.reshape(-1, len(sweep)), motion.reshape(3, -1, len(sweep))
        buehler_motion(flat[0], duty, offset, sweep, slow, fast, self._parameters.blend, flat[1])
        return ShaftMotion(*motion)

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and curvature; the curvature is infinite without blends."""
        p = self._parameters
        _, slow, fast = self._speeds(steer)
        jump = float(np.abs(fast - slow).max())
        bend = jump / p.blend if p.blend > 0 else (np.inf if jump > 0 else 0.0)
        return float(np.maximum(slow, fast).max()), bend


def prepare() -> None:
    """Load or make the machine code, so that no tick waits for it."""
    compile_for(buehler_motion, *given(2, 1, 1, 1, 1, 1), NUMBER, *out(3))
