"""Forces of the friction law as functions of its parameters, with derivatives, for the fit.

The viscous ansatz is F = -mu N L slip with L = I + w w^T. Coulomb's law is F = -mu N L u, u = L slip /
|L slip|: it has the same tractions along and across w, its largest forces form an ellipse, and it is the
gradient of a dissipation, which (I + w w^T) slip / |slip| is not. It is what ``model.quasistatic.frames``
solves.

The search runs over log mu and either w itself (three numbers a leg) or log(1 + |w|^2) along a given
direction (two), erratum E8: the logarithm of the ratio of the two tractions, in which the search does not
get stuck at w = 0. Where forces are known up to one scale a frame, the best scale of each frame is
eliminated: with sigma = F.h / h.h the residual F - sigma h keeps an exact derivative (variable projection;
Golub and Pereyra, 1973), and no scale has to be searched for.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw
from model.traction.force_scale import force_scale
from model.values.arrays import BoolArray, FloatArray

START_W = 0.3  # at w = 0 the force does not change with w, and no search could begin
LARGEST_RATIO = 100.0  # of the two tractions of a leg, at the start
ROUNDS = 4


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


class FrictionSearch:
    """Residuals and Jacobian over (log mu_k, then w_k or log(1 + |w_k|^2)).

    Args:
        contacts: The data.
        direction: Direction of each w, (N, 2), unit length; None to search all of w.
        frame_scale: Whether forces are known up to one scale a frame only.
    """

    def __init__(
        self, contacts: Contacts, direction: FloatArray | None, *, frame_scale: bool
    ) -> None:
        self.contacts, self.direction, self.frame_scale = contacts, direction, frame_scale
        self.legs = contacts.load.shape[1]

    def split(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mu, (N,), and w, (N, 2)."""
        mu, rest = np.exp(theta[: self.legs]), theta[self.legs :]
        w: FloatArray
        if self.direction is None:
            w = rest.reshape(-1, 2)
        else:
            w = np.sqrt(np.expm1(np.maximum(rest, 0.0)))[:, None] * self.direction
        return mu, w

    @property
    def lowest(self) -> FloatArray:
        """Lower bounds of the parameters, (P,)."""
        if self.direction is None:
            return np.full(3 * self.legs, -np.inf)
        return np.repeat([-np.inf, 0.0], self.legs)

    def residual(self, theta: FloatArray) -> FloatArray:
        """Measured minus fitted force of the feet used, (M,) [N]."""
        bare, _ = self._bare(theta)
        left: FloatArray = self.contacts.force - self._scale(bare)[:, None, None] * bare
        return left[self.contacts.used].ravel()

    def jacobian(self, theta: FloatArray, *, of_scale: bool = True) -> FloatArray:
        """Of ``residual``, (M, P).

        Args:
            theta: Parameters, (P,).
            of_scale: False leaves out how the scale follows the residual itself: that part is as
                random as the residual and tells nothing about parameters. For errors, not for a search.
        """
        bare, slope = self._bare(theta)
        scale = self._scale(bare)[:, None, None, None]
        total = -scale * slope
        if self.frame_scale:
            power = np.sum(bare**2, axis=(1, 2))
            safe = np.where((power > 0) & (scale[:, 0, 0, 0] > 0), power, np.inf)[:, None]
            pointing = self.contacts.force if of_scale else scale[..., 0] * bare
            along = np.einsum("fki,fkip->fp", pointing, slope)
            along -= 2 * scale[:, 0, 0] * np.einsum("fki,fkip->fp", bare, slope)
            total -= bare[..., None] * (along / safe)[:, None, None, :]
        return total[self.contacts.used].reshape(-1, len(theta))

    def start(self) -> FloatArray:
        """Begin at the best symmetric traction matrix of each leg, which is a linear fit."""
        data, legs = self.contacts, self.legs
        pressed = -data.load[..., None] * data.motion
        traction = np.tile(np.eye(2), (legs, 1, 1))
        for _ in range(ROUNDS):
            scale = self._scale(np.einsum("kij,fkj->fki", traction, pressed))
            traction = np.stack(
                [_symmetric(scale[:, None] * pressed[:, k], data.force[:, k]) for k in range(legs)]
            )
        values, vectors = np.linalg.eigh(traction)
        determined = (values[:, 1] > 0) & data.used.any(axis=0)
        high = np.where(determined, values[:, 1], 1.0)
        if self.direction is None:
            low = _sound(np.where(determined, values[:, 0], 1.0), high)
            w = np.maximum(np.sqrt(high / low - 1), START_W)[:, None] * vectors[:, :, 1]
        else:
            across = np.stack([-self.direction[:, 1], self.direction[:, 0]], axis=1)
            low = np.einsum("ki,kij,kj->k", across, traction, across)
            along = np.einsum("ki,kij,kj->k", self.direction, traction, self.direction)
            low = _sound(np.where(determined, low, 1.0), high)
            w = np.log(np.maximum(along / low, 1 + START_W**2))[:, None]
        if determined.any():
            low = np.where(determined, low, np.exp(np.mean(np.log(low[determined]))))
        return np.concatenate([np.log(low), np.where(determined[:, None], w, 0.0).ravel()])

    def _scale(self, bare: FloatArray) -> FloatArray:
        if not self.frame_scale:
            return np.ones(len(bare))
        return np.nan_to_num(force_scale(bare, self.contacts.force).scale)

    def _bare(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force before the frame's scale, (F, N, 2), and its derivative, (F, N, 2, P)."""
        (mu, w), motion, legs = self.split(theta), self.contacts.motion, self.legs
        pressed = -(mu * self.contacts.load)[..., None]
        matrix = np.eye(2) + w[:, :, None] * w[:, None, :]
        if self.direction is None:  # d matrix / d w_i, (N, 2, 2, 2)
            one = w[:, None, :, None] * np.eye(2)[:, None, :]
            matrix_slope = one + one.transpose(0, 2, 1, 3)
        else:
            along = self.direction[:, :, None] * self.direction[:, None, :]
            matrix_slope = (np.exp(theta[legs:])[:, None, None] * along)[..., None]
        pulled = np.einsum("kij,fkj->fki", matrix, motion)
        pulled_slope = np.einsum("kijq,fkj->fkiq", matrix_slope, motion)
        if self.contacts.law is FrictionLaw.COULOMB:
            size = np.linalg.norm(pulled, axis=2, keepdims=True)
            size = np.where(size > 0, size, 1.0)
            unit = pulled / size
            turning = (
                pulled_slope
                - unit[..., None] * np.einsum("fki,fkiq->fkq", unit, pulled_slope)[:, :, None, :]
            )
            pulled = np.einsum("kij,fkj->fki", matrix, unit)
            pulled_slope = np.einsum("kijq,fkj->fkiq", matrix_slope, unit)
            pulled_slope += np.einsum("kij,fkjq->fkiq", matrix, turning / size[..., None])
        bare = pressed * pulled
        slope = np.zeros((*bare.shape, len(theta)))
        width = matrix_slope.shape[-1]
        for leg in range(legs):
            first = legs + width * leg
            slope[:, leg, :, leg] = bare[:, leg]
            slope[:, leg, :, first : first + width] = (
                pressed[:, leg, :, None] * pulled_slope[:, leg]
            )
        return bare, slope


def _sound(low: FloatArray, high: FloatArray) -> FloatArray:
    """Where the lower traction is absurd, as it is where nothing tells it, begin with the higher."""
    sound: FloatArray = np.where(low > high / LARGEST_RATIO, low, high)
    return sound


def _symmetric(motion: FloatArray, force: FloatArray) -> FloatArray:
    """Symmetric D, (2, 2), for which D motion is nearest to force, (F, 2) each."""
    x, y, zero = motion[:, 0], motion[:, 1], np.zeros(len(motion))
    design = np.concatenate([np.stack([x, y, zero], axis=1), np.stack([zero, x, y], axis=1)])
    xx, xy, yy = np.linalg.lstsq(design, np.concatenate([force[:, 0], force[:, 1]]), rcond=1e-9)[0]
    return np.array([[xx, xy], [xy, yy]])
