"""A round disk with N legs on its rim, each with two rotations and a vertical slide.

The paper measures run time on it. Legs are limited so that no two workspaces overlap: a foot stays
inside its own sector of the disk, at most ``WORKSPACE_SHARE`` of the way to the sector's edge.
"""

import numpy as np

from model.errors import ModelError
from model.systems.system import System, equal_contacts, even_times
from model.systems.two_axis import swing
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

FEWEST_LEGS, MOST_LEGS = 3, 50
WORKSPACE_SHARE = 0.9
LARGEST_YAW_RAD = 0.5
LARGEST_ROLL_RAD = 0.2
LARGEST_SLIDE_M = 0.02
LARGEST_RATES = np.array([2.0, 2.0, 0.1])  # of random velocities [rad/s], [rad/s], [m/s]

RADIUS_M = 0.20
REACH_M = 0.12  # hip to foot, horizontally
HEIGHT_M = 0.12
WEIGHT_N = 40.0
SINK_M = 0.008  # how far the body sinks with all feet down
MU = 1.0
OUTLINE_POINTS = 48

FREQUENCY_HZ = 0.5
STRIDE_M = 0.04  # of each foot along x, back and forth; less where the workspace is smaller
LIFT_M = 0.02  # rise and fall of each foot about its middle


def disk(legs: int = 6, *, cycles: float = 4.0, spin: float = 0.0) -> System:
    """A disk that walks on alternate legs.

    With an odd number of legs two neighbours are in step. Three legs can never lift a foot, so three
    legs only shuffle; four and five tilt from foot to foot.

    Args:
        legs: Number of legs, 3 to 50.
        cycles: Length of the motion.
        spin: Share of the motion that turns the disk to the left instead of moving it along x, 0 to 1.

    Raises:
        ModelError: A number of legs or a share that makes no disk.
    """
    _check(legs)
    if not 0 <= spin <= 1:
        raise ModelError(f"spin is a share from 0 to 1, not {spin:g}")
    omega = 2 * np.pi * FREQUENCY_HZ
    time_s = even_times(cycles / FREQUENCY_HZ)
    azimuth = _azimuth(legs)
    theta = omega * time_s[:, None] + np.pi * np.arange(legs)
    half = min(STRIDE_M / 2, REACH_M * np.sin(largest_yaw(legs)))
    # a foot's path along x, split into what its yaw (along the rim) and its roll (outwards) can do
    yaw = half / REACH_M * (spin - (1 - spin) * np.sin(azimuth))
    roll = half / HEIGHT_M * (1 - spin) * np.cos(azimuth)
    # the slide makes up for the height that the roll would add, so feet in stance stay level
    along = np.column_stack([yaw, roll, -REACH_M * roll])
    lift = np.array([0.0, 0.0, -LIFT_M])
    sine, cosine = np.sin(theta)[..., None], np.cos(theta)[..., None]
    around = np.linspace(0, 2 * np.pi, OUTLINE_POINTS, endpoint=False)
    return System(
        name="disk",
        description=f"disk with {legs} legs on its rim, {FREQUENCY_HZ:g} Hz",
        time_s=time_s,
        feet=_feet(along * cosine + lift * sine, omega * (lift * cosine - along * sine)),
        contact=disk_contact(legs),
        weight_n=WEIGHT_N,
        outline_B=RADIUS_M * np.column_stack([np.cos(around), np.sin(around)]),
        hips_B=RADIUS_M * np.column_stack([np.cos(azimuth), np.sin(azimuth)]),
    )


def random_disk_poses(count: int, legs: int, rng: np.random.Generator) -> FootMotion:
    """Random poses and velocities, evenly distributed over the joints' ranges.

    They are no series in time: each frame stands on its own.

    Args:
        count: Number of frames F.
        legs: Number of legs N, 3 to 50.
        rng: Where the numbers come from.

    Returns:
        Feet in the body frame, (F, N, 3).

    Raises:
        ModelError: A count below 1 or a number of legs that makes no disk.
    """
    _check(legs)
    if count < 1:
        raise ModelError(f"the number of poses must be positive, not {count}")
    limits = (largest_yaw(legs), LARGEST_ROLL_RAD, LARGEST_SLIDE_M, *LARGEST_RATES)
    drawn = np.stack([rng.uniform(-limit, limit, (count, legs)) for limit in limits], axis=-1)
    return _feet(drawn[..., :3], drawn[..., 3:])


def disk_contact(legs: int) -> ContactParameters:
    """Leg springs that let the disk sink by ``SINK_M`` whatever the number of legs."""
    _check(legs)
    return equal_contacts(legs, WEIGHT_N / (legs * SINK_M), MU)


def largest_yaw(legs: int) -> float:
    """Largest yaw that keeps each foot inside its own sector [rad]."""
    half_width = WORKSPACE_SHARE * RADIUS_M * np.sin(np.pi / legs)  # at the hip, the narrow end [m]
    return min(LARGEST_YAW_RAD, float(np.arcsin(min(half_width / REACH_M, 1.0))))


def _feet(joints: FloatArray, rates: FloatArray) -> FootMotion:
    azimuth = _azimuth(joints.shape[1])
    pivot = np.column_stack([RADIUS_M * np.cos(azimuth), RADIUS_M * np.sin(azimuth), 0 * azimuth])
    arm = np.array([0.0, REACH_M, -HEIGHT_M])
    outward = np.zeros((len(azimuth), 3))
    outward[:, 0] = azimuth - np.pi / 2  # a leg's own y axis points away from the disk
    return swing(pivot, arm, joints + outward, rates)


def _azimuth(legs: int) -> FloatArray:
    """Sector of each leg: a pair of legs straddles the x axis, so that left and right are alike."""
    azimuth: FloatArray = 2 * np.pi * (np.arange(legs) + 0.5) / legs
    return azimuth


def _check(legs: int) -> None:
    if not FEWEST_LEGS <= legs <= MOST_LEGS:
        raise ModelError(f"a disk has {FEWEST_LEGS} to {MOST_LEGS} legs, not {legs}")
