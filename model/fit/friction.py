"""Friction of each leg from measured horizontal forces and slips (sec:params, eqn:anisotropic).

The law is the viscous ansatz F = -mu N (I + w w^T) slip, whose forces are known up to one positive scale
a frame, or Coulomb's law with the same tractions along and across w, in newtons
(``model.fit.friction_search``). What can be seen, and what not:

* With one scale a frame, the common scale of mu does not show, nor does it move any velocity: the mean of
  mu is a convention.
* w and -w are the same traction: w_x is taken positive (w_y if w_x is 0), a length along a given
  direction not negative.
* A leg that always slips in one direction tells two of its three numbers: mu and w are indistinguishable.
* Near w = 0 the traction does not change with w to first order. A w whose square is within two standard
  errors of 0 is reported as undetermined: the leg is isotropic as far as these data go.
* Traction is only ever added along w (erratum E10): a wheel is a small mu with w across its rolling.
* Slips count as exact. Noise on them makes mu too small; nothing here knows.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.fit.friction_search import Contacts, FrictionSearch, choose_contacts
from model.fit.result import FitResult, Spread, minimise, spread
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import BoolArray, FloatArray, readonly

# w^2 must be so many of its standard errors from 0.
ERRORS_FROM_ZERO = 2.0
AXES = ("w_x", "w_y")


@dataclass(frozen=True, slots=True, eq=False)
class FrictionFit:
    """Fitted friction and how well it is known; residuals are forces [N].

    Attributes:
        mu: (N,), [1] for Coulomb's law, [s/m] up to one scale for the viscous ansatz.
        anisotropy: w in body axes, (N, 2).
        result: mu of all legs, then w_x and w_y of each (24), or the length of each w (18).
    """

    mu: FloatArray
    anisotropy: FloatArray
    result: FitResult


@dataclass(frozen=True, slots=True, eq=False)
class FrictionForm:
    """Which law is fitted, and what is held by convention.

    Attributes:
        direction: Direction of w of each leg, (N, 2): two numbers a leg, 18 parameters of a hexapod
            with its K. None for a free w: three numbers a leg, 24 parameters (erratum E8).
        law: Viscous ansatz or Coulomb's law.
        frame_scale: Whether forces are known up to one scale a frame; None for the law's own answer:
            the viscous ansatz has the scale, Coulomb's law has none.
        mean_mu: With a frame scale, the mean of mu over the legs that the data determine. None leaves it
            at 1 and reports every mu as undetermined.
        rest_m_s: Feet no faster than this rest, and are not used [m/s]; Coulomb's law needs it positive
            for noisy slips, because a resting foot's force is not its law's.

    Raises:
        ModelError: A value is impossible.
    """

    direction: FloatArray | None = None
    law: FrictionLaw = FrictionLaw.VISCOUS
    frame_scale: bool | None = None
    mean_mu: float | None = None
    rest_m_s: float = 0.0

    def __post_init__(self) -> None:
        if self.mean_mu is not None and not (self.scaled and self.mean_mu > 0):
            raise ModelError(
                "a mean of mu must be positive, and has a meaning with a frame scale only"
            )
        if not self.rest_m_s >= 0:
            raise ModelError(
                f"the speed of a foot at rest must not be negative, not {self.rest_m_s}"
            )

    @property
    def scaled(self) -> bool:
        """Whether each frame has a scale of its own."""
        return self.law is FrictionLaw.VISCOUS if self.frame_scale is None else self.frame_scale


def fit_friction(
    force_xy_B: FloatArray,  # noqa: N803
    load_n: FloatArray,
    slip_B: FloatArray,  # noqa: N803
    form: FrictionForm,
    *,
    leg_names: Sequence[str] = (),
) -> FrictionFit:
    """Fit mu and w of each leg by least squares on the horizontal forces.

    Args:
        force_xy_B: Measured horizontal forces of the ground on the feet, body axes, (F, N, 2) [N].
        load_n: Measured (or modelled) vertical forces, (F, N) [N]; a foot with none is not used.
        slip_B: Velocities of the feet over the ground, body axes, (F, N, 2) [m/s].
        form: The law, and what is held.
        leg_names: Names for the result; numbers if there are none.

    Raises:
        ModelError: Shapes do not fit, a value is impossible, or no foot can be used.

    Reference: Wu, Zhao, Revzen, sec:params, eqn:anisotropic, eqn:viscf.
    """
    scaled, direction, mean_mu = form.scaled, form.direction, form.mean_mu
    legs = load_n.shape[-1]
    _check(force_xy_B, load_n, slip_B, direction)
    names = tuple(leg_names) or tuple(str(leg) for leg in range(legs))
    contacts, left_out = choose_contacts(force_xy_B, load_n, slip_B, form.law, form.rest_m_s)
    unit = None if direction is None else direction / np.linalg.norm(direction, axis=1)[:, None]
    search = FrictionSearch(contacts, unit, frame_scale=scaled)
    size = float(np.linalg.norm(contacts.force))
    theta, converged = minimise(
        search.residual,
        search.jacobian,
        search.start(),
        size=size,
        lowest=search.lowest,
    )
    if unit is None:
        w = theta[legs:].reshape(legs, 2)  # of w and -w the one with w_x > 0
        w[(w[:, 0] < 0) | ((w[:, 0] == 0) & (w[:, 1] < 0))] *= -1
    residual = search.residual(theta)
    scalable = np.arange(len(theta)) < legs
    frames = int(contacts.used.any(axis=1).sum())
    known = spread(
        search.jacobian(theta, of_scale=False),
        residual,
        size,
        lost=frames if scaled else 0,
        scaled=scalable if scaled else None,
        scale_share=np.where(scalable, np.exp(theta), 0.0),
    )
    if scaled and known.reference.any():
        mean = 1.0 if mean_mu is None else mean_mu
        theta[:legs] += np.log(mean / np.mean(np.exp(theta[known.reference])))
    mu, w = search.split(theta)
    isotropic = _isotropic(theta, known, legs, free=unit is None)
    open_ = known.undetermined | isotropic
    if scaled and mean_mu is None:
        open_ = open_ | scalable
    values = np.append(mu, w.ravel() if unit is None else np.linalg.norm(w, axis=1))
    slope = np.append(mu, np.ones(len(theta) - legs))  # of the values by theta
    if unit is not None:
        # theta = log(1 + w^2); where w is 0 no linear error of it exists, and it is open anyway
        slope[legs:] = 0.5 * np.exp(theta[legs:]) / np.maximum(values[legs:], np.finfo(float).tiny)
    slope[open_] = np.nan
    covariance = known.covariance * slope[:, None] * slope
    axes = AXES if unit is None else ("w",)
    labels = (
        *(f"mu {name}" for name in names),
        *(f"{axis} {name}" for name in names for axis in axes),
    )
    result = FitResult(
        names=labels,
        values=readonly(values),
        covariance=readonly(covariance),
        residual_rms=float(np.sqrt(np.mean(residual**2))),
        frames_used=frames,
        left_out=left_out,
        undetermined=tuple(label for label, lost in zip(labels, open_, strict=True) if lost),
        warnings=_warnings(
            names, known, isotropic, contacts, load_n, conventional=scaled and mean_mu is None
        ),
        converged=converged,
    )
    return FrictionFit(readonly(mu), readonly(w), result)


def _isotropic(theta: FloatArray, known: Spread, legs: int, *, free: bool) -> BoolArray:
    """Whose w is indistinguishable from 0, (P,) bool."""
    lost = np.zeros(len(theta), dtype=bool)
    for at in np.arange(legs, len(theta)).reshape(legs, -1):
        # |w|^2, or log(1 + |w|^2)
        square = theta[at] @ theta[at] if free else theta[at[0]]
        slope = 2 * theta[at] if free else np.ones(1)
        error = np.sqrt(slope @ known.covariance[np.ix_(at, at)] @ slope)
        lost[at] = not square > ERRORS_FROM_ZERO * error
    return lost


def _warnings(
    names: tuple[str, ...],
    known: Spread,
    isotropic: BoolArray,
    contacts: Contacts,
    load: FloatArray,
    *,
    conventional: bool,
) -> tuple[str, ...]:
    legs = len(names)
    no_w = np.any((known.undetermined | isotropic)[legs:].reshape(legs, -1), axis=1)
    warnings = []
    if conventional:
        warnings.append(
            "the common scale of mu does not show where forces have a scale of their own in each "
            "frame: its mean is set to 1 by convention"
        )
    for leg, name in enumerate(names):
        moved = contacts.used[:, leg] & (contacts.motion[:, leg] != 0).any(axis=1)
        if not (np.nan_to_num(load[:, leg]) > 0).any():
            warnings.append(f"leg {name} was never loaded, so that its friction is not known")
        elif not moved.any():
            warnings.append(f"leg {name} never slipped, so that its friction is not known")
        elif known.undetermined[leg]:
            warnings.append(
                f"mu and w of leg {name} are indistinguishable: it slips too little, or always in "
                "one direction"
            )
        elif no_w[leg]:
            warnings.append(
                f"the w of leg {name} is indistinguishable from 0: no more traction along it than across"
            )
    return tuple(warnings)


def _check(
    force: FloatArray,
    load: FloatArray,
    slip: FloatArray,
    direction: FloatArray | None,
) -> None:
    if load.ndim != 2 or force.shape != (*load.shape, 2) or slip.shape != force.shape:
        raise ModelError(
            "forces and slips must be (F, N, 2) and loads (F, N), not "
            f"{force.shape}, {slip.shape} and {load.shape}"
        )
    if direction is not None and (
        direction.shape != (load.shape[1], 2) or not (np.linalg.norm(direction, axis=1) > 0).all()
    ):
        raise ModelError("the directions of w must be (N, 2) and none of them zero")
