"""A round disk with N legs on its rim, each with two rotations and a vertical slide.

The paper measures run time on it. Legs are limited so that no two workspaces overlap: a foot stays
inside its own sector of the disk, at most ``WORKSPACE_SHARE`` of the way to the sector's edge.
"""

import numpy as np

from model.errors import ModelError
from model.systems.system import System, equal_contacts, even_times
from model.systems.two_axis import LegAngles, swing
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

FEWEST_LEGS, MOST_LEGS = 3, 50
WORKSPACE_SHARE = 0.9
LARGEST_YAW_RAD = 0.5
LARGEST_ROLL_RAD = 0.2
LARGEST_SLIDE_M = 0.02
LARGEST_JOINT_SPEED = 2.0  # of random velocities [rad/s]; slides run at a twentieth of it [m/s]
SLIDE_SPEED_SHARE = 0.05

RADIUS_M = 0.20
REACH_M = 0.12  # hip to foot, horizontally
HEIGHT_M = 0.12
WEIGHT_N = 40.0
SINK_M = 0.008  # how far the body sinks with all feet down
MU = 1.0
OUTLINE_POINTS = 48


def disk(
    legs: int = 6,
    *,
    cycles: float = 4.0,
    frequency_hz: float = 0.5,
    rate_hz: float = 100.0,
    stride_m: float = 0.04,
    lift_m: float = 0.02,
    spin: float = 0.0,
) -> System:
    """A disk that walks on alternate legs.

    With an odd number of legs two neighbours are in step. Three legs can never lift a foot, so three
    legs only shuffle; four and five tilt from foot to foot.

    Args:
        legs: Number of legs, 3 to 50.
        cycles: Length of the motion.
        frequency_hz: Gait cycles a second.
        rate_hz: Frames a second.
        stride_m: Way of each foot along x, back and forth; less where the workspace is smaller [m].
        lift_m: Rise and fall of each foot about its middle [m].
        spin: Share of the motion that turns the disk to the left instead of moving it along x, 0 to 1.

    Raises:
        ModelError: A number of legs or a share that makes no disk.
    """
    _check(legs)
    if not 0 <= spin <= 1:
        raise ModelError(f"spin is a share from 0 to 1, not {spin:g}")
    time_s = even_times(cycles / frequency_hz, rate_hz)
    azimuth = _azimuth(legs)
    theta = 2 * np.pi * frequency_hz * time_s[:, None] + np.pi * np.arange(legs)
    omega = 2 * np.pi * frequency_hz
    half = min(stride_m / 2, REACH_M * np.sin(largest_yaw(legs)))
    # a foot's way along x, split into what its yaw (along the rim) and its roll (outwards) can do
    yaw_share = -(1 - spin) * np.sin(azimuth) + spin
    yaw_size, roll_size = half * yaw_share / REACH_M, half * (1 - spin) * np.cos(azimuth) / HEIGHT_M
    roll, roll_rate = roll_size * np.cos(theta), -roll_size * omega * np.sin(theta)
    angles = LegAngles(
        yaw=yaw_size * np.cos(theta),
        roll=roll,
        # the slide makes up for the height that the roll would add, so feet in stance stay level
        slide=-lift_m * np.sin(theta) - REACH_M * roll,
        yaw_rate=-yaw_size * omega * np.sin(theta),
        roll_rate=roll_rate,
        slide_rate=-lift_m * omega * np.cos(theta) - REACH_M * roll_rate,
    )
    around = np.linspace(0, 2 * np.pi, OUTLINE_POINTS, endpoint=False)
    return System(
        name="disk",
        description=f"disk with {legs} legs on its rim, {frequency_hz:g} Hz",
        time_s=time_s,
        feet=_feet(legs, angles),
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

    def evenly(limit: float) -> FloatArray:
        return rng.uniform(-limit, limit, (count, legs))

    speed = LARGEST_JOINT_SPEED
    angles = LegAngles(
        yaw=evenly(largest_yaw(legs)),
        roll=evenly(LARGEST_ROLL_RAD),
        slide=evenly(LARGEST_SLIDE_M),
        yaw_rate=evenly(speed),
        roll_rate=evenly(speed),
        slide_rate=evenly(SLIDE_SPEED_SHARE * speed),
    )
    return _feet(legs, angles)


def disk_contact(legs: int) -> ContactParameters:
    """Leg springs that let the disk sink by ``SINK_M`` whatever the number of legs."""
    _check(legs)
    return equal_contacts(legs, WEIGHT_N / (legs * SINK_M), MU)


def largest_yaw(legs: int) -> float:
    """Largest yaw that keeps each foot inside its own sector [rad]."""
    half_width = WORKSPACE_SHARE * RADIUS_M * np.sin(np.pi / legs)  # at the hip, the narrow end [m]
    return min(LARGEST_YAW_RAD, float(np.arcsin(min(half_width / REACH_M, 1.0))))


def _feet(legs: int, angles: LegAngles) -> FootMotion:
    azimuth = _azimuth(legs)
    pivot = np.column_stack([RADIUS_M * np.cos(azimuth), RADIUS_M * np.sin(azimuth), 0 * azimuth])
    arm = np.tile([0.0, REACH_M, -HEIGHT_M], (legs, 1))
    outward = LegAngles(
        angles.yaw + azimuth - np.pi / 2,  # a leg's own y axis points away from the disk
        angles.roll,
        angles.slide,
        angles.yaw_rate,
        angles.roll_rate,
        angles.slide_rate,
    )
    return swing(pivot, arm, outward)


def _azimuth(legs: int) -> FloatArray:
    """Sector of each leg: a pair of legs straddles the x axis, so that left and right are alike."""
    azimuth: FloatArray = 2 * np.pi * (np.arange(legs) + 0.5) / legs
    return azimuth


def _check(legs: int) -> None:
    if not FEWEST_LEGS <= legs <= MOST_LEGS:
        raise ModelError(f"a disk has {FEWEST_LEGS} to {MOST_LEGS} legs, not {legs}")
