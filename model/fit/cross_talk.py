"""Stage two of the in-situ calibration: a 6 x 6 correction of each sensor from a robot that stands still.

In a pose at rest the wrenches of the feet carry the weight::

    sum_k X_k (I + D_k) y_k = (weight up, no moment about the centre of mass),   y = s - a(q)

X_k takes a wrench at sensor k to the body's origin: six equations a pose, linear in the 36 unknowns a
sensor. However many poses there are, the balance cannot see an error that all sensors share: with
D_k = X_k^-1 E X_k the sum changes by E times the weight, which is nothing for every E whose column of
vertical force is zero. Those 30 directions (a common scale of the horizontal forces is one) are left at
zero by construction, unless feet are taken to touch at a *point*: it passes on no moment, so force and
moment of one sensor must agree about where the foot is. That has little weight (``POINT_FOOT_WEIGHT``),
because it relies on the linkage's dimensions, and decides what the balance leaves open. What neither shows
stays at zero by the ridge: the one that predicts left-out poses best, but no weaker than entries of size
``EXPECTED`` ask for under the noise. The *resolution* of an unknown is the share of it that the data, not
the ridge, decides (the diagonal of Backus and Gilbert's resolution matrix): 1 known, 0 untouched.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, IntArray, part_of, readonly

STRENGTHS = np.logspace(-9, 1, 41)  # ridge, as a share of the largest squared singular value
# Size of cross-talk that is no surprise, as a share of the load.
EXPECTED = 0.03
POINT_FOOT_WEIGHT = 0.1
FOLDS = 5
SHUFFLE_SEED = 1
# Poses whose shafts all agree to this are the same pose and never both left out and fitted to [rad].
SAME_POSE_RAD = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class SensorPlaces:
    """Where the sensors are and what they carry.

    Attributes:
        origin_B: Sensor origins, body frame, (N, 3) [m].
        yaw_rad: Rotation about z from body axes to sensor axes, (N,).
        weight_n: Weight of the whole robot [N].
        up: +1 where a sensor's z axis points up, -1 where it is turned over about its x axis, (N,);
            None for all of them upright.
    """

    origin_B: FloatArray  # noqa: N815 - frame suffix
    yaw_rad: FloatArray
    weight_n: float
    up: IntArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class StillPoses:
    """Poses at rest, P of them, N legs.

    Attributes:
        angle_rad: Shaft angles, (P, N).
        sensed: Mean readings, (P, N, 6) [N, N m]; NaN where there is none.
        in_air: True where the foot touches nothing, (P, N).
        up_B: Direction of "up" in body axes, (P, 3).
        standing: False for poses of a robot that is hung up, (P,).
        lever: From each sensor to where its foot touches, sensor axes, (P, N, 3) [m]; NaN where
            unknown.
    """

    angle_rad: FloatArray
    sensed: FloatArray
    in_air: BoolArray
    up_B: FloatArray  # noqa: N815 - frame suffix
    standing: BoolArray
    lever: FloatArray

    def __len__(self) -> int:
        return len(self.angle_rad)

    def part(self, chosen: BoolArray) -> "StillPoses":
        """Return some of the poses."""
        return part_of(self, chosen)


@dataclass(frozen=True, slots=True, eq=False)
class CrossTalkFit:
    """The fit of all sensors.

    Attributes:
        correction: D, (N, 6, 6).
        resolution: Share of each entry of D that the data decides, (N, 6, 6), 0 to 1.
        strength: Ridge strength chosen, as a share of the largest squared singular value.
        condition: Condition number of the scaled design without the ridge, shared directions left out.
        poses: Poses used.
    """

    correction: FloatArray
    resolution: FloatArray
    strength: float
    condition: float
    poses: int


def wrench_maps(places: SensorPlaces) -> FloatArray:
    """Return X, (N, 6, 6): a wrench in sensor axes at the sensor to body axes at the body's origin."""
    turn = Rotation.from_euler("z", places.yaw_rad[:, None]).as_matrix()
    if places.up is not None:
        turn[:, :, 1:] *= places.up[:, None, None]
    maps = np.zeros((len(turn), 6, 6))
    maps[:, :3, :3] = maps[:, 3:, 3:] = turn
    maps[:, 3:, :3] = _cross(places.origin_B) @ turn
    return maps


def _cross(vector: FloatArray) -> FloatArray:
    """Matrix of the cross product with a vector, (..., 3) to (..., 3, 3)."""
    matrix: FloatArray = np.cross(np.eye(3), vector[..., None, :])
    return matrix


def balance_residual(wrench: FloatArray, poses: StillPoses, places: SensorPlaces) -> FloatArray:
    """Return what the wrenches of the feet and the weight leave over, (P, 6) [N, N m], body origin.

    Args:
        wrench: Wrenches of the feet, sensor axes, (P, N, 6); those of feet in the air are not used.
        poses: The poses.
        places: The sensors.
    """
    loaded = np.where(poses.in_air[..., None], 0.0, wrench)
    total: FloatArray = np.einsum("nij,pnj->pi", wrench_maps(places), loaded)
    total[:, :3] -= places.weight_n * poses.up_B
    return total


def usable(poses: StillPoses) -> BoolArray:
    """Return which poses balance the weight: standing, and a reading of every loaded foot, (P,)."""
    known = np.isfinite(poses.sensed).all(axis=2) | poses.in_air
    return poses.standing & known.all(axis=1) & ~poses.in_air.all(axis=1)


def fit_cross_talk(
    free: FloatArray, poses: StillPoses, places: SensorPlaces, *, point_feet: bool
) -> CrossTalkFit:
    """Fit D of all sensors.

    Args:
        free: Readings less a(q), (P, N, 6) [N, N m].
        poses: The same poses, all usable.
        places: The sensors.
        point_feet: Whether feet touch at a point and take no moment there.

    Raises:
        ModelError: Too few different poses to leave some out.
    """
    different = int(pose_groups(poses.angle_rad).max(initial=-1)) + 1
    if different < FOLDS:
        raise ModelError(
            f"{different} different standing poses are too few to fit cross-talk; "
            f"record at least {FOLDS}, better {6 * poses.angle_rad.shape[1]}"
        )
    loaded = np.where(poses.in_air[..., None], 0.0, free)
    rows_scale, wrench_scale = _scales(loaded, places)
    design = _design(loaded, places, wrench_scale) / rows_scale[None, :, None]
    target = -balance_residual(free, poses, places) / rows_scale
    left_open = np.zeros((design.shape[2], 0))
    if point_feet:
        foot_design, foot_target = _foot_rows(loaded, poses.lever, wrench_scale)
        share = POINT_FOOT_WEIGHT / rows_scale[-1]
        design = np.concatenate([design, share * foot_design], axis=1)
        target = np.concatenate([target, share * foot_target], axis=1)
    else:
        left_open = shared_directions(places, wrench_scale)
        design = design - (design @ left_open) @ left_open.T
    strength = _choose_strength(design, target, folds(poses.angle_rad, FOLDS))
    flat = design.reshape(-1, design.shape[2])
    left, singular, right = np.linalg.svd(flat, full_matrices=False)
    share = singular**2 / (singular**2 + strength * singular[0] ** 2)
    solution = right.T @ (share / np.maximum(singular, 1e-300) * (left.T @ target.ravel()))
    resolution = np.einsum("s,sc->c", share, right**2)
    count = poses.angle_rad.shape[1]
    unit = wrench_scale[:, None] / wrench_scale[None, :]
    needed = singular[: flat.shape[1] - left_open.shape[1]]
    full_rank = len(needed) == flat.shape[1] - left_open.shape[1]
    return CrossTalkFit(
        correction=readonly(solution.reshape(count, 6, 6) * unit),
        resolution=readonly(resolution.reshape(count, 6, 6)),
        strength=strength,
        condition=float(needed[0] / needed[-1]) if full_rank and needed[-1] > 0 else np.inf,
        poses=len(poses),
    )


def shared_directions(places: SensorPlaces, wrench_scale: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the scaled D that no balance can see, (36 N, 30).

    Args:
        places: The sensors.
        wrench_scale: Scale of each axis, (6,) [N, N m].
    """
    maps = wrench_maps(places)
    inverse = np.linalg.inv(maps)
    unit = wrench_scale[None, :] / wrench_scale[:, None]
    unseen = maps[:, [0, 1, 3, 4, 5]]  # not the vertical force: the weight shows its errors
    directions = np.einsum("nir,ncj->rcnij", inverse, unseen) * unit
    basis: FloatArray = np.linalg.qr(directions.reshape(30, -1).T)[0]
    return basis


def pose_groups(angle_rad: FloatArray) -> IntArray:
    """Number poses so that those with the same shaft angles share a number, (P,)."""
    cells = np.rint(np.remainder(angle_rad, 2 * np.pi) / SAME_POSE_RAD).astype(np.int64)
    _, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))  # in the order of time
    groups: IntArray = order[inverse.ravel()].astype(np.int64)
    return groups


def folds(angle_rad: FloatArray, count: int) -> IntArray:
    """Deal the poses into parts of equal size, equal poses into the same one, (P,) 0 to count - 1.

    Shuffled, the same way every time: legs lifted in turn would otherwise all fall into one part.
    """
    groups = pose_groups(angle_rad)
    parts = np.arange(groups.max(initial=-1) + 1) % count
    dealt: IntArray = np.random.default_rng(SHUFFLE_SEED).permutation(parts)[groups]
    return dealt


def _scales(loaded: FloatArray, places: SensorPlaces) -> tuple[FloatArray, FloatArray]:
    """Scales of the balance's rows and of a sensor's axes, (6,) each [N, N m]."""
    reach = float(np.sqrt((places.origin_B**2).sum(axis=1).mean()))
    force = float(np.sqrt((loaded[..., :3] ** 2).mean())) or 1.0
    torque = float(np.sqrt((loaded[..., 3:] ** 2).mean())) or 1.0
    rows = np.repeat([1.0, reach if reach > 0 else 1.0], 3)
    return rows, np.repeat([force, torque], 3)


def _design(loaded: FloatArray, places: SensorPlaces, wrench_scale: FloatArray) -> FloatArray:
    """Return d balance / d scaled D, (P, 6, 36 N)."""
    maps = wrench_maps(places) * wrench_scale  # columns times the scale of the row of D
    product = np.einsum("nri,pnj->prnij", maps, loaded / wrench_scale)
    rows: FloatArray = product.reshape(len(loaded), 6, -1)
    return rows


def _foot_rows(
    loaded: FloatArray, lever: FloatArray, wrench_scale: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the moment about each foot as rows: design (P, 3 N, 36 N) and target (P, 3 N) [N m]."""
    poses, count = loaded.shape[:2]
    known = np.asarray(np.isfinite(lever).all(axis=2))
    moment = np.zeros((poses, count, 3, 6))  # wrench at the sensor to moment about the foot
    moment[known, :, :3], moment[known, :, 3:] = -_cross(lever[known]), np.eye(3)
    target = -np.einsum("pnri,pni->pnr", moment, loaded)
    design = np.zeros((poses, count, 3, count, 6, 6))
    product = np.einsum("pnri,pnj->pnrij", moment * wrench_scale, loaded / wrench_scale)
    legs = np.arange(count)
    design[:, legs, :, legs] = product.transpose(1, 0, 2, 3, 4)
    return design.reshape(poses, 3 * count, -1), target.reshape(poses, -1)


def _choose_strength(design: FloatArray, target: FloatArray, parts: IntArray) -> float:
    """Return the ridge strength that predicts the balance of left-out poses best, within reason."""
    error = np.zeros(len(STRENGTHS))
    for fold in range(FOLDS):
        out = parts == fold
        kept = design[~out].reshape(-1, design.shape[2])
        left, singular, right = np.linalg.svd(kept, full_matrices=False)
        pressed = left.T @ target[~out].ravel()
        tested = design[out, :6].reshape(-1, design.shape[2]) @ right.T
        wanted = target[out, :6].ravel()
        for index, strength in enumerate(STRENGTHS):
            gain = singular / (singular**2 + strength * singular[0] ** 2)
            error[index] += float(((tested @ (gain * pressed) - wanted) ** 2).sum())
    best = int(np.argmin(error))
    noise = error[best] / target[:, :6].size
    largest = float(np.linalg.norm(design.reshape(-1, design.shape[2]), 2))
    return max(float(STRENGTHS[best]), float(noise / (EXPECTED * largest) ** 2))
