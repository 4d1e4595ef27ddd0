"""A slithering body: a chain of contacts along a serpenoid curve, waves running from head to tail.

The heading along the body is a sine of arc length (Hirose, "Biologically Inspired Robots", 1993). Each
contact slides easily along the body and badly across it: the paper's w points across the body, where
it adds traction. The body frame sits at the centre of mass with the mean heading of the chain.
"""

import numpy as np

from model.errors import ModelError
from model.systems.system import System, equal_contacts, even_times
from model.values.arrays import FloatArray, readonly
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion

FEWEST_CONTACTS = 4
FREQUENCY_HZ = 0.5
LENGTH_M, MASS_KG = 0.9, 1.0
WAVES = 2.0  # along the body
HEADING_AMPLITUDE_RAD = 0.8
STIFFNESS_N_M = 300.0  # of the ground under each contact
MU = 0.2  # along the body


def slither(contacts: int = 16, *, cycles: float = 4.0, across: float = 3.0) -> System:
    """A body that slithers forward. Contact order: tail to head.

    Args:
        contacts: Number of contacts.
        cycles: Length of the motion.
        across: Length of w: traction across the body is ``1 + across^2`` times that along it.

    Raises:
        ModelError: Too few contacts for a wave.
    """
    if contacts < FEWEST_CONTACTS:
        raise ModelError(f"a slithering body needs at least {FEWEST_CONTACTS} contacts")
    time_s = even_times(cycles / FREQUENCY_HZ)
    place = (np.arange(contacts) + 0.5) / contacts
    theta = 2 * np.pi * (FREQUENCY_HZ * time_s[:, None] + WAVES * place)
    heading = _about_mean(HEADING_AMPLITUDE_RAD * np.sin(theta))
    turning = _about_mean(
        HEADING_AMPLITUDE_RAD * 2 * np.pi * FREQUENCY_HZ * np.cos(theta)
    )  # [rad/s]
    tangent = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    normal = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)
    link = LENGTH_M / contacts
    flat = np.zeros((*heading.shape, 1))
    feet = FootMotion(
        np.concatenate([_along_chain(tangent * link), flat], axis=-1),
        np.concatenate([_along_chain(normal * turning[..., None] * link), flat], axis=-1),
    )
    return System(
        name="slither",
        description=f"slithering body with {contacts} contacts, {FREQUENCY_HZ:g} Hz",
        time_s=time_s,
        feet=feet,
        contact=equal_contacts(contacts, STIFFNESS_N_M, MU),
        weight_n=MASS_KG * STANDARD_GRAVITY,
        anisotropy_B=readonly(across * normal),
    )


def _about_mean(values: FloatArray) -> FloatArray:
    centred: FloatArray = values - values.mean(axis=1, keepdims=True)
    return centred


def _along_chain(links: FloatArray) -> FloatArray:
    """Middles of links laid end to end, about their mean; (F, N, 2) to (F, N, 2)."""
    middles = np.cumsum(links, axis=1) - links / 2
    return _about_mean(middles)
