"""Multipods: 6 to 12 leaf-spring legs in pairs, moved by a wave that runs along the body.

Each contralateral pair turns as one rigid segment with two degrees of freedom, yaw and roll, on a
rigid backbone. Rolling puts one foot of the pair down and lifts the other; yawing in quadrature moves
the foot that is down backward.

The paper gives K = 1, mu = 1 and a weight of N without units. With its motion tracking in
millimetres that is 1 N/mm, which is what we take: 1 N/m would sink the robot by a metre.
"""

import numpy as np

from model.errors import ModelError
from model.systems.leaf_spring import Segments
from model.systems.system import System, box, equal_contacts, even_times
from model.systems.two_axis import LegAngles, rotations, swing
from model.values.arrays import FloatArray

LEG_COUNTS = (6, 8, 10, 12)
SPACING_M = 0.16  # pair to pair, assumed
HALF_WIDTH_M = 0.20  # assumed
HEIGHT_M = 0.10  # assumed


def multipod(
    legs: int = 6,
    *,
    cycles: float = 4.0,
    frequency_hz: float = 0.3,
    phase_offset: float = 1.35 * np.pi,
    rate_hz: float = 100.0,
    yaw_amplitude: float = 0.35,
    roll_amplitude: float = 0.12,
    stiffness: float = 1000.0,
    mu: float = 1.0,
) -> System:
    """A multipod with an undulation gait.

    Args:
        legs: 6, 8, 10 or 12. Foot order: left then right of each pair, hind pair first.
        cycles: Length of the motion.
        frequency_hz: Gait cycles a second.
        phase_offset: Phase of each pair ahead of the pair in front of it [rad].
        rate_hz: Frames a second.
        yaw_amplitude: Of each pair [rad].
        roll_amplitude: Of each pair [rad].
        stiffness: Of each leg [N/m].
        mu: Friction coefficient.

    Raises:
        ModelError: Another number of legs.
    """
    time_s = even_times(cycles / frequency_hz, rate_hz)
    pivot, arm, angles = _joints(
        legs, time_s, frequency_hz, phase_offset, yaw_amplitude, roll_amplitude
    )
    return System(
        name="multipod",
        description=f"multipod with {legs} leaf-spring legs, {frequency_hz:g} Hz, "
        f"phase offset {phase_offset / np.pi:.2f} pi",
        time_s=time_s,
        feet=swing(pivot, arm, angles),
        contact=equal_contacts(legs, stiffness, mu),
        weight_n=float(legs),
        outline_B=box(SPACING_M * (legs // 2 - 0.4), 0.25 * HALF_WIDTH_M),
        hips_B=pivot[:, :2],
    )


def multipod_segments(
    legs: int,
    time_s: FloatArray,
    *,
    frequency_hz: float = 0.3,
    phase_offset: float = 1.35 * np.pi,
    yaw_amplitude: float = 0.35,
    roll_amplitude: float = 0.12,
) -> Segments:
    """The rigid segment behind each leg spring, as motion tracking would see it.

    Args:
        legs: 6, 8, 10 or 12.
        time_s: (F,) [s].
        frequency_hz: As for ``multipod``.
        phase_offset: As for ``multipod``.
        yaw_amplitude: As for ``multipod``.
        roll_amplitude: As for ``multipod``.
    """
    pivot, _, angles = _joints(
        legs, time_s, frequency_hz, phase_offset, yaw_amplitude, roll_amplitude
    )
    frames = np.broadcast_to(pivot, (len(time_s), *pivot.shape))
    return Segments(frames, rotations(angles.yaw, angles.roll))


def _joints(
    legs: int,
    time_s: FloatArray,
    frequency_hz: float,
    phase_offset: float,
    yaw_amplitude: float,
    roll_amplitude: float,
) -> tuple[FloatArray, FloatArray, LegAngles]:
    """Pivots and arms, (N, 3) [m], and joint angles of every leg."""
    if legs not in LEG_COUNTS:
        raise ModelError(f"a multipod has 6, 8, 10 or 12 legs, not {legs}")
    pair = np.arange(legs) // 2
    side = np.where(np.arange(legs) % 2 == 0, 1.0, -1.0)
    still = np.zeros(legs)
    pivot = np.column_stack([SPACING_M * (pair - (legs // 2 - 1) / 2), still, still])
    arm = np.column_stack([still, HALF_WIDTH_M * side, still - HEIGHT_M])
    omega = 2 * np.pi * frequency_hz
    theta = omega * time_s[:, None] - phase_offset * pair
    none = np.zeros_like(theta)
    angles = LegAngles(
        yaw=yaw_amplitude * np.sin(theta),
        # the left foot is down while the yaw grows, which moves it backward
        roll=-roll_amplitude * np.cos(theta),
        slide=none,
        yaw_rate=yaw_amplitude * omega * np.cos(theta),
        roll_rate=roll_amplitude * omega * np.sin(theta),
        slide_rate=none,
    )
    return pivot, arm, angles
