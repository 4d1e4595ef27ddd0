"""Logs in which less is known than in the one that they are made of: truth, headings, forces, phase."""

from dataclasses import replace
from typing import Any

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from record.log.recording import Recording

TRUTH = ("truth_position_W", "truth_quaternion_xyzw", "truth_velocity_B", "truth_force_n")
HEADING = TRUTH[1:3]
MIDDLE = 600  # a tick within the walking


def nothing(log: Recording) -> FloatArray:
    return np.full(len(log.t_s), np.nan)


def turned_off(log: Recording, known: BoolArray, *names: str) -> Recording:
    """A log whose truth is known in some ticks only."""
    some: dict[str, Any] = {}
    for name in names:
        some[name] = getattr(log, name).copy()
        some[name][~known] = np.nan
    return replace(log, **some)


def places_only(log: Recording) -> Recording:
    return turned_off(log, np.zeros(len(log.t_s), bool), *HEADING)


def gaps(log: Recording) -> Recording:
    return turned_off(log, np.arange(len(log.t_s)) // 100 % 3 != 1, *TRUTH)


def late(log: Recording) -> Recording:
    return turned_off(log, np.arange(len(log.t_s)) >= MIDDLE, *TRUTH)


def half_headings(log: Recording) -> Recording:
    return turned_off(log, np.arange(len(log.t_s)) < MIDDLE, *HEADING)


def one_pose(log: Recording) -> Recording:
    return turned_off(log, np.arange(len(log.t_s)) == MIDDLE, *TRUTH)


def no_truth(log: Recording) -> Recording:
    return turned_off(log, np.zeros(len(log.t_s), bool), *TRUTH)


def no_forces(log: Recording) -> Recording:
    return replace(log, force_n=np.full_like(log.force_n, np.nan),
                   truth_force_n=np.full_like(log.truth_force_n, np.nan))  # fmt: skip


def standing_truth(log: Recording) -> Recording:
    ticks = len(log.t_s)
    return replace(
        log,
        truth_position_W=np.repeat(log.truth_position_W[:1], ticks, axis=0),
        truth_quaternion_xyzw=np.repeat(log.truth_quaternion_xyzw[:1], ticks, axis=0),
        truth_velocity_B=np.zeros_like(log.truth_velocity_B),
    )


def no_phase(log: Recording) -> Recording:
    return replace(log, gait_phase=nothing(log))
