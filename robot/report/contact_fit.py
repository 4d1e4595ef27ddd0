"""Stiffness and friction of the legs, fitted to the walking frames of a log."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.fit.friction import fit_friction
from model.fit.result import FitResult
from model.fit.stiffness import fit_stiffness
from model.quasistatic.frames import FrictionLaw
from model.values.parameters import ContactParameters
from robot.report.walk_frames import WalkFrames

# The paper's naive parameters: K = 10 where the weight is 1 (lengths in metres), mu = 1, no w.
NAIVE_STIFFNESS = 10.0
NAIVE_MU = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Fitted parameters, the law they are for, and how well they are known."""

    law: FrictionLaw
    weight_n: float
    contact: ContactParameters
    stiffness: FitResult
    friction: FitResult


def fit_contact(
    walk: WalkFrames,
    names: tuple[str, ...],
    *,
    free_w: bool,
    rest_m_s: float,
    law: FrictionLaw = FrictionLaw.VISCOUS,
) -> Fits:
    """Fit stiffness and friction.

    Args:
        walk: Frames to fit to.
        names: Leg names.
        free_w: 24 parameters instead of 18, whose w lies fore and aft.
        rest_m_s: Feet no faster than this rest. What holds them is statics, not the friction law: they
            tell nothing of it, and lead the fit astray.
        law: Friction law to fit; the viscous ansatz is the paper's.

    Raises:
        ModelError: These frames cannot be fitted to.
    """
    weight = float(np.median(walk.force[..., 2].sum(axis=1)))
    if weight <= 0:
        raise ModelError("the measured vertical forces do not carry a weight: check their bias")
    legs = len(names)
    springs = fit_stiffness(
        walk.feet,
        walk.force[..., 2],
        weight,
        np.full(legs, NAIVE_STIFFNESS * weight),
        leg_names=names,
    )
    friction = fit_friction(
        walk.force[..., :2],
        np.maximum(walk.force[..., 2], 0.0),
        walk.slip,
        direction=None if free_w else np.tile([1.0, 0.0], (legs, 1)),
        law=law,
        mean_mu=NAIVE_MU if law is FrictionLaw.VISCOUS else None,
        rest_m_s=rest_m_s,
        leg_names=names,
    )
    contact = ContactParameters(springs.values, friction.mu, friction.anisotropy)
    return Fits(law, weight, contact, springs, friction.result)
