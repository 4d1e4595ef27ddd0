"""Leg stiffness from measured load shares (sec:params).

What can be seen, and what not:

* Only K / weight enters the model: K and the weight scaled together move no share. In newtons per metre
  K is known no better than the weight is.
* With a weight given, the common scale of K shows in the shares only if the unloaded feet of a frame do
  not lie in one plane: a stiffer robot shares the load less evenly and lifts its high feet. With feet in
  a plane only the ratios of K show.
* Three feet in contact carry what statics says, whatever K is: only frames with four or more loaded
  feet, and the choice of which feet are loaded, tell anything. An alternating tripod says little.
* Height and slopes, if they are measured, show the scale at once: the sag is weight over stiffness.

The search runs over log K, so that every K is positive.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.fit.result import FitResult, Spread, minimise, spread
from model.support.frames import load_derivatives
from model.values.arrays import BoolArray, FloatArray, readonly

# A foot that carries more than this share of the weight is in contact.
CONTACT_SHARE = 0.02


@dataclass(frozen=True, slots=True)
class StiffnessConventions:
    """What is wished of stiffnesses that the data leave open.

    Attributes:
        spread_weight: How much legs are wished to be alike: the square of share noise over expected
            spread of log K, which stays small beside many frames; 0 to let the data speak alone.
        mean_stiffness: Hold the mean of the fitted stiffnesses here [N/m]: the scale by convention. The
            mean is over the legs that the data determine. None leaves it to the data.
    """

    spread_weight: float = 1e-4
    mean_stiffness: float | None = None

    def __post_init__(self) -> None:
        mean = self.mean_stiffness
        if not self.spread_weight >= 0 or (mean is not None and not mean > 0):
            raise ModelError("mean stiffness must be positive, spread_weight not negative")


DATA_AND_LIKENESS = StiffnessConventions()


def fit_stiffness(
    feet_B: FloatArray,  # noqa: N803
    vertical_n: FloatArray,
    weight_n: float,
    start: FloatArray,
    *,
    leg_names: Sequence[str] = (),
    conventions: StiffnessConventions = DATA_AND_LIKENESS,
    pose: FloatArray | None = None,
) -> FitResult:
    """Fit K to the shares of the weight that the feet in contact carry.

    Minimises the squared errors of the shares, summed over feet and frames, and those of the pose where
    one is given, plus ``spread_weight`` times sum_k (log K_k - mean log K)^2.

    Args:
        feet_B: Unloaded feet in the body frame, (F, N, 3) [m].
        vertical_n: Measured vertical forces of the ground on the feet, (F, N); only their shares count.
        weight_n: Weight carried [N].
        start: Where the search begins, (N,) [N/m], positive. A scale that does not show stays there.
        leg_names: Names for the result; numbers if there are none.
        conventions: What is wished where the data are silent.
        pose: Measured slope_x, slope_y [rad] and height of the body origin [m], (F, 3), if they are
            known; NaN where not. A height error is weighed as the change of load it would mean.

    Returns:
        K of each leg, (N,) [N/m]; residuals are shares of the weight.

    Raises:
        ModelError: Shapes do not fit, a value is not positive, or no frame can be used.

    Reference: Wu, Zhao, Revzen, sec:params and eqn:zpj.
    """
    _check(feet_B, vertical_n, weight_n, start, pose)
    frames = _choose_frames(feet_B, vertical_n, weight_n, start, pose)
    names = tuple(leg_names) or tuple(str(leg) for leg in range(len(start)))
    search = _Search(frames, weight_n, conventions.spread_weight)
    theta, converged = search.run(np.log(start))
    known = search.spread(theta, relative=False)
    relative = search.spread(theta, relative=True)
    if conventions.mean_stiffness is not None:
        # the mean is over legs that the data tell next to each other, or over all if they tell none
        reference = relative.reference if relative.reference.any() else np.ones_like(start, bool)
        search.hold_mean(conventions.mean_stiffness, reference)
        theta, converged = search.run(np.log(start))
        known = relative = search.spread(theta, relative=True)
    stiffness = search.stiffness(theta)
    undetermined = tuple(f"K {n}" for n, u in zip(names, known.undetermined, strict=True) if u)
    return FitResult(
        names=tuple(f"K {name}" for name in names),
        values=readonly(stiffness),
        covariance=readonly(known.covariance * stiffness[:, None] * stiffness),
        residual_rms=float(np.sqrt(np.mean(search.evaluate(theta)[0][: search.shares] ** 2))),
        frames_used=len(frames.feet),
        left_out=frames.left_out,
        undetermined=undetermined,
        warnings=_warnings(names, known, relative, np.any(frames.contact, axis=0)),
        converged=converged,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Frames:
    """Frames of which the fit makes use.

    Attributes:
        feet: Unloaded feet, (F, N, 3) [m].
        contact: Loaded, as measured or as the model has it, (F, N).
        share: Measured share of the load, (F, N); of meaning in contact only.
        pose: Measured slopes [rad] and height [m], (F, 3), NaN where not known.
        pose_weight: What an error of the pose means as an error of a share, (3,).
        left_out: Why frames were left out, and how many.
    """

    feet: FloatArray
    contact: BoolArray
    share: FloatArray
    pose: FloatArray
    pose_weight: FloatArray
    left_out: tuple[tuple[str, int], ...]


def _choose_frames(
    feet: FloatArray,
    vertical: FloatArray,
    weight: float,
    start: FloatArray,
    pose: FloatArray | None,
) -> _Frames:
    """Leave out what cannot be used, and count it."""
    everything = np.concatenate([feet.reshape(len(feet), -1), vertical], axis=1)
    present = np.isfinite(everything).all(axis=1)
    solved = load_derivatives(np.where(present[:, None, None], feet, 0.0), start, weight).solved
    stands = np.isfinite(solved.load_n).all(axis=1)
    contact: BoolArray = (vertical > CONTACT_SHARE * weight) | (np.nan_to_num(solved.load_n) > 0)
    total: FloatArray = np.sum(np.where(contact, vertical, 0.0), axis=1)
    used: BoolArray = present & stands & (total > CONTACT_SHARE * weight)
    left_out = (
        ("a foot or a force is missing", int((~present).sum())),
        ("the robot tips", int((present & ~stands).sum())),
        ("no foot is loaded", int((present & stands & ~used).sum())),
    )
    if not used.any():
        raise ModelError(
            "no frame can be used to fit the stiffness: "
            + ", ".join(f"{why} in {count}" for why, count in left_out if count)
        )
    chosen = feet[used]
    lever = float(np.sqrt(np.mean(chosen[..., :2] ** 2)))
    # an error of a height means a load of K times it: the same as a share in the fit
    weights = float(start.mean()) / weight * np.array([lever, lever, 1.0])
    return _Frames(
        feet=chosen,
        contact=contact[used],
        share=vertical[used] / total[used, None],
        pose=np.full((len(chosen), 3), np.nan) if pose is None else pose[used],
        pose_weight=weights,
        left_out=tuple((why, count) for why, count in left_out if count),
    )


class _Search:
    """Residuals and their Jacobian as functions of log K, one model run for both."""

    def __init__(self, frames: _Frames, weight_n: float, spread_weight: float) -> None:
        self._frames, self._weight = frames, weight_n
        legs = frames.feet.shape[1]
        self._penalty = np.sqrt(spread_weight) * (np.eye(legs) - 1 / legs)
        self._posed = np.isfinite(frames.pose)
        self.shares = int(frames.contact.sum())  # the first rows of the residual
        self._mean = np.nan
        self._reference = np.zeros(legs, dtype=bool)
        self._last: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def hold_mean(self, mean: float, reference: BoolArray) -> None:
        """Hold the mean of K over some legs from now on."""
        self._mean, self._reference, self._last = mean, reference, None

    def stiffness(self, theta: FloatArray) -> FloatArray:
        """K, (N,)."""
        reference = self._reference
        if not reference.any():
            return np.exp(theta)
        relative: FloatArray = np.exp(theta - theta[reference].mean())
        held: FloatArray = self._mean * relative / relative[reference].mean()
        return held

    def run(self, theta: FloatArray) -> tuple[FloatArray, bool]:
        """Search from ``theta``; return where it ended and whether it converged."""
        return minimise(
            lambda at: self.evaluate(at)[0],
            lambda at: self.evaluate(at)[1],
            theta,
            size=float(np.sqrt(len(self._frames.feet))),
        )

    def evaluate(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Share errors, pose errors and penalty, (M,), and their Jacobian, (M, N)."""
        if self._last is not None and np.array_equal(self._last[0], theta):
            return self._last[1], self._last[2]
        frames, stiffness = self._frames, self.stiffness(theta)
        model = load_derivatives(frames.feet, stiffness, self._weight)
        by_log = np.eye(len(theta))  # d log K / d theta
        if self._reference.any():
            held = np.where(self._reference, stiffness, 0.0)
            by_log = by_log - held / held.sum()
        share = np.nan_to_num(model.solved.load_n) / self._weight
        pose = (model.solved.pose - frames.pose) * frames.pose_weight
        pose_slope = model.pose_slope * frames.pose_weight[:, None]
        errors = ((share - frames.share)[frames.contact], pose[self._posed])
        slopes = (model.load_slope[frames.contact] / self._weight, pose_slope[self._posed])
        residual = np.concatenate([*errors, self._penalty @ np.log(stiffness)])
        slope = np.concatenate([*slopes, self._penalty])
        self._last = theta.copy(), residual, slope @ by_log
        return self._last[1], self._last[2]

    def spread(self, theta: FloatArray, *, relative: bool) -> Spread:
        """Errors of log K, or of log K next to each other, and what the data leave open."""
        residual, jacobian = self.evaluate(theta)
        measured = len(residual) - len(theta)
        penalty = jacobian[measured:]
        return spread(
            jacobian[:measured],
            residual[:measured],
            float(np.linalg.norm(self._frames.share)),
            lost=len(self._frames.feet),  # shares of a frame sum to one
            penalty=penalty.T @ penalty,
            scaled=np.ones(len(theta), dtype=bool) if relative else None,
            scale_share=self.stiffness(theta),
        )


def _warnings(
    names: tuple[str, ...], known: Spread, relative: Spread, loaded: BoolArray
) -> tuple[str, ...]:
    never, silent, scale = (
        "leg {} was never loaded, so that its stiffness is not known",
        "the stiffness of leg {} moves no share beyond the noise: walk with four or more feet loaded",
        "the common scale of the stiffnesses does not show in these load shares and stays where the search "
        "began: only frames whose unloaded feet do not lie in a plane show it",
    )
    legs = tuple(
        (silent if was else never).format(name)
        for name, unknown, was in zip(names, relative.undetermined, loaded, strict=True)
        if unknown
    )
    lost_scale = int(known.undetermined.sum()) > int(relative.undetermined.sum())
    return (scale, *legs) if lost_scale else legs


def _check(
    feet: FloatArray,
    vertical: FloatArray,
    weight: float,
    start: FloatArray,
    pose: FloatArray | None,
) -> None:
    if feet.ndim != 3 or feet.shape[2] != 3 or vertical.shape != feet.shape[:2]:
        raise ModelError(
            f"feet must be (F, N, 3) and forces (F, N), not {feet.shape} and {vertical.shape}"
        )
    if start.shape != feet.shape[1:2] or not (start > 0).all():
        raise ModelError("the start must be one positive stiffness a leg")
    if pose is not None and pose.shape != (len(feet), 3):
        raise ModelError(f"pose must be (F, 3), not {pose.shape}")
    if not weight > 0:
        raise ModelError("the weight must be positive")
