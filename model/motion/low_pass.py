"""A first-order low pass that stands in for inertia, and its coefficient chosen from spectra.

    y[n] = gamma y[n-1] + (1 - gamma) x[n]

Source: Wu, Zhao, Revzen, Ghost Robotics Spirit; there gamma is chosen by hand.
"""

import numpy as np
from scipy.optimize import minimize_scalar

from model.errors import ModelError
from model.motion.filters import recursion
from model.values.arrays import FloatArray

LARGEST_GAMMA = 0.995
GRID = 40  # first looks; spectra of real signals can have more than one dip
SHORTEST = 64  # samples; fewer make no spectrum
SEGMENT = 256
# Bins weaker than this share of a component's strongest are noise, not motion.
FAINTEST = 1e-3


def low_pass(signal: FloatArray, gamma: float) -> FloatArray:
    """Filter along the first axis, at rest at the first value.

    A sample that is not finite has no answer and interrupts the filter, which begins again after it.

    Args:
        signal: (F,) or (F, C).
        gamma: 0 (no filter) to below 1.

    Returns:
        Filtered signal of the same shape; NaN where the signal was.

    Raises:
        ModelError: Gamma outside [0, 1).
    """
    if not 0 <= gamma < 1:
        raise ModelError(f"gamma must be at least 0 and below 1, not {gamma:g}")
    filtered = np.array(signal.reshape(len(signal), -1), dtype=np.float64)
    known = np.isfinite(filtered).all(axis=1)
    filtered[~known] = np.nan
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        recursion(filtered[begin:end], filtered[begin].copy(), gamma, 1.0 - gamma, 0.0)
    return filtered.reshape(signal.shape)


def choose_gamma(predicted: FloatArray, reference: FloatArray, rate_hz: float) -> float:
    """The gamma that brings the spectrum of a prediction nearest to that of a measurement.

    Minimises the mean squared difference of the logarithms of the two Welch spectra, all components
    together, without the zero frequency and without the bins in which one of the two has next to no
    power: a walking robot's prediction has few harmonics, a measurement has noise between them. The
    two need not be in step in time.

    Args:
        predicted: Raw prediction, (F,) or (F, C).
        reference: What was measured, the same components; its length may differ.
        rate_hz: Samples a second of both.

    Raises:
        ModelError: Shapes do not fit, the signals are too short, constant or not finite.
    """
    x, y = predicted.reshape(len(predicted), -1), reference.reshape(len(reference), -1)
    if x.shape[1] != y.shape[1]:
        raise ModelError(f"{x.shape[1]} predicted components but {y.shape[1]} measured ones")
    if min(len(x), len(y)) < SHORTEST:
        raise ModelError(f"a spectrum needs at least {SHORTEST} samples")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ModelError("a spectrum needs signals without gaps")
    segment = min(SEGMENT, len(x), len(y))
    wanted, offered = _spectrum(y, rate_hz, segment), _spectrum(x, rate_hz, segment)
    strong = np.logical_and(*(one > FAINTEST * one.max(axis=0) for one in (wanted, offered)))
    if not strong.any():
        raise ModelError("the two signals have no frequency in common")
    goal = np.log(wanted[strong])

    def mismatch(gamma: float) -> float:
        filtered = _spectrum(low_pass(x, gamma), rate_hz, segment)[strong]
        return float(np.mean((np.log(filtered) - goal) ** 2))

    grid = np.linspace(0.0, LARGEST_GAMMA, GRID)
    best = int(np.argmin([mismatch(float(gamma)) for gamma in grid]))
    bounds = (float(grid[max(best - 1, 0)]), float(grid[min(best + 1, GRID - 1)]))
    result = minimize_scalar(mismatch, bounds=bounds, method="bounded", options={"xatol": 1e-5})
    return float(result.x)


def _spectrum(signal: FloatArray, rate_hz: float, segment: int) -> FloatArray:
    from scipy.signal import welch  # a third of a second: as late as it is needed

    _, power = welch(signal, fs=rate_hz, nperseg=segment, axis=0)
    spectrum: FloatArray = power[1:]
    return spectrum
