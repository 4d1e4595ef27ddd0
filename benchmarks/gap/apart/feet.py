"""Forces of the floor on the feet, as their sensors average them between two records."""

from typing import Any

import mujoco
import numpy as np

from benchmarks.gap.apart.fault import Fault
from benchmarks.gap.apart.layout import FOOT_RADIUS_M, LEGS, FloatArray

PULLED_BELOW_M = 0.006


def foot_geoms(model: Any) -> list[int]:
    """Return the numbers of the feet's balls in a model, in the order of ``LEGS``."""
    return [model.geom(f"{leg}_tip").id for leg in LEGS]


class Feet:
    """Feet of one run."""

    def __init__(self, model: Any, fault: Fault) -> None:
        self._model = model
        self._floor = model.geom("floor").id
        geoms = foot_geoms(model)
        self._foot_of = {geom: foot for foot, geom in enumerate(geoms)}
        self._suction_n = fault.suction_n
        self._pulled = LEGS.index(fault.place) if fault.suction_n else 0
        self._pulled_geom = geoms[self._pulled]
        self._pulled_body = model.geom_bodyid[self._pulled_geom]
        self._sum_n = np.zeros((len(LEGS), 3))
        self._steps = 0
        self._wrench = np.zeros(6)

    def pull(self, data: Any) -> None:
        """Let the floor pull at a foot with suction, before a step."""
        if self._suction_n:
            near = data.geom_xpos[self._pulled_geom][2] - FOOT_RADIUS_M < PULLED_BELOW_M
            data.xfrc_applied[self._pulled_body, 2] = -self._suction_n if near else 0.0

    def feel(self, data: Any) -> None:
        """Add the contacts of a step.

        The sensor of a foot with suction feels the contact, which carries the pull. While no foot touches
        the floor it feels the pull itself: so it was in the runs of the page.
        """
        for index in range(data.ncon):
            contact = data.contact[index]
            foot = self._foot_of.get(contact.geom2)
            if foot is not None and contact.geom1 == self._floor:  # a plane is always the first
                mujoco.mj_contactForce(self._model, data, index, self._wrench)
                self._sum_n[foot] += contact.frame.reshape(3, 3).T @ self._wrench[:3]
        if self._suction_n and not data.ncon:
            self._sum_n[self._pulled, 2] += data.xfrc_applied[self._pulled_body, 2]
        self._steps += 1

    def mean_force_n(self, rotation: FloatArray) -> FloatArray:
        """Return the mean force since the last call in the trunk's axes, (6, 3) [N].

        Args:
            rotation: Of the trunk, from its axes to those of the floor, (3, 3).
        """
        mean_n: FloatArray = (self._sum_n / max(self._steps, 1)) @ rotation
        self._sum_n[:] = 0
        self._steps = 0
        return mean_n
