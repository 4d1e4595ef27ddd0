"""A slithering body: a chain of contacts along a serpenoid curve, waves running from head to tail.

The heading along the body is a sine of arc length (Hirose, "Biologically Inspired Robots", 1993). Each
contact slides easily along the body and badly across it: the paper's w points across the body, where
it adds traction. The body frame sits at the centre of mass with the mean heading of the chain.
"""

import numpy as np
from scipy.constants import g as standard_gravity

from model.errors import ModelError
from model.systems.system import System, equal_contacts, even_times
from model.values.arrays import FloatArray, readonly
from model.values.legs import FootMotion

FEWEST_CONTACTS = 4


def slither(
    contacts: int = 16,
    *,
    cycles: float = 4.0,
    frequency_hz: float = 0.5,
    rate_hz: float = 100.0,
    length_m: float = 0.9,
    waves: float = 2.0,
    heading_amplitude: float = 0.8,
    across: float = 3.0,
    mass_kg: float = 1.0,
    stiffness: float = 300.0,
    mu: float = 0.2,
) -> System:
    """A body that slithers forward. Contact order: tail to head.

    Args:
        contacts: Number of contacts.
        cycles: Length of the motion.
        frequency_hz: Waves a second.
        rate_hz: Frames a second.
        length_m: Length along the body [m].
        waves: Waves along the body.
        heading_amplitude: Of the sine of headings [rad].
        across: Length of w: traction across the body is ``1 + across^2`` times that along it.
        mass_kg: [kg].
        stiffness: Of the ground under each contact [N/m].
        mu: Friction coefficient along the body.

    Raises:
        ModelError: Too few contacts for a wave.
    """
    if contacts < FEWEST_CONTACTS:
        raise ModelError(f"a slithering body needs at least {FEWEST_CONTACTS} contacts")
    time_s = even_times(cycles / frequency_hz, rate_hz)
    place = (np.arange(contacts) + 0.5) / contacts
    theta = 2 * np.pi * (frequency_hz * time_s[:, None] + waves * place)
    heading = _about_mean(heading_amplitude * np.sin(theta))
    turning = _about_mean(heading_amplitude * 2 * np.pi * frequency_hz * np.cos(theta))  # [rad/s]
    tangent = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    normal = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)
    link = length_m / contacts
    flat = np.zeros((*heading.shape, 1))
    feet = FootMotion(
        np.concatenate([_along_chain(tangent * link), flat], axis=-1),
        np.concatenate([_along_chain(normal * turning[..., None] * link), flat], axis=-1),
    )
    return System(
        name="slither",
        description=f"slithering body with {contacts} contacts, {frequency_hz:g} Hz",
        time_s=time_s,
        feet=feet,
        contact=equal_contacts(contacts, stiffness, mu),
        weight_n=mass_kg * standard_gravity,
        anisotropy_B=readonly(across * normal),
    )


def _about_mean(values: FloatArray) -> FloatArray:
    centred: FloatArray = values - values.mean(axis=1, keepdims=True)
    return centred


def _along_chain(links: FloatArray) -> FloatArray:
    """Middles of links laid end to end, about their mean; (F, N, 2) to (F, N, 2)."""
    middles = np.cumsum(links, axis=1) - links / 2
    return _about_mean(middles)
