"""Which feet of a log tell about friction: loaded, moving, and measured in full."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Feet of which the fit makes use.

    Attributes:
        force: Measured horizontal force, (F, N, 2) [N]; 0 where not used.
        load: Vertical force, (F, N) [N]; 0 where not used.
        motion: Slip, (F, N, 2) [m/s], or for Coulomb's law its direction [1]; 0 where not used.
        used: (F, N) bool.
        law: Friction law.
    """

    force: FloatArray
    load: FloatArray
    motion: FloatArray
    used: BoolArray
    law: FrictionLaw


def choose_contacts(
    force: FloatArray, load: FloatArray, slip: FloatArray, law: FrictionLaw, rest: float
) -> tuple[Contacts, tuple[tuple[str, int], ...]]:
    """Leave out what cannot be used, and count it.

    Args:
        force: Measured horizontal forces, (F, N, 2) [N].
        load: Vertical forces, (F, N) [N].
        slip: (F, N, 2) [m/s].
        law: Whether forces follow the slip or its direction.
        rest: Feet no faster than this are left out [m/s].

    Returns:
        The feet used, and why others were left out, and how many.

    Raises:
        ModelError: No foot can be used.
    """
    present = np.isfinite(force).all(axis=2) & np.isfinite(load) & np.isfinite(slip).all(axis=2)
    speed = np.where(present, np.linalg.norm(np.where(np.isfinite(slip), slip, 0.0), axis=2), 0.0)
    loaded: BoolArray = present & (np.nan_to_num(load) > 0)
    used: BoolArray = loaded & (speed > rest)
    left_out = (
        ("a force or slip is missing (feet)", int((~present).sum())),
        ("not loaded (feet)", int((present & ~loaded).sum())),
        ("at rest (feet)", int((loaded & ~used).sum())),
        ("no foot can be used (frames)", int((~used.any(axis=1)).sum())),
    )
    if not used.any():
        raise ModelError("no loaded foot slips in these data: there is nothing to fit friction to")
    size = np.where(used & (law is FrictionLaw.COULOMB), speed, 1.0)
    motion = np.where(used[..., None], slip, 0.0) / size[..., None]
    contacts = Contacts(
        np.where(used[..., None], force, 0.0), np.where(used, load, 0.0), motion, used, law
    )
    return contacts, tuple((why, count) for why, count in left_out if count)
