"""A copy of the model with the numbers of a machine in it: drive, friction, inertia, gravity, contact.

Where MuJoCo has the quantity itself (``frictionloss``, ``damping``, ``armature``, masses, gravity), the
effect is an edit of it, so that a correction can be written into the file as it was simulated. A loop whose
torque has no limit is a spring and a damper of the joint, pulled by a force: the same, and quicker.
"""

import copy
import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from gap.machines.mujoco.drive import TorqueLaw, torque_law
from gap.machines.mujoco.rigid_model import RigidModel
from gap.machines.mujoco.settings import BodyNumbers, RigidSettings, WorldNumbers
from model.values.arrays import FloatArray


class ModelEditor:
    """Edits copies of one model; ``kind`` is that of its drive."""

    def __init__(self, rigid: RigidModel, kind: str) -> None:
        self.rigid, self.kind = rigid, kind
        self._ends = far_ends(rigid)
        self._joint = rigid.model.dof_jntid[rigid.speed]

    def edited(self, settings: RigidSettings) -> Any:
        """Return a copy of the model with these settings in it, driven by targets if it has actuators.

        It has none where forces will do: ``stiffness`` times the target on each joint.
        """
        laws = [torque_law(self.kind, p) for p in settings.joints]
        changed = [
            (number, numbers, end)
            for number, numbers, end in zip(
                self.rigid.body, settings.bodies, self._ends, strict=True
            )
            if numbers != BodyNumbers()
        ]
        free = not changed and all(math.isinf(law.limit) for law in laws)
        lean = self.rigid.lean if free else None
        model = copy.copy(self.rigid.model if lean is None else lean)
        self._add_joints(model, settings, laws)
        if lean is not None:
            self._add_springs(model, laws)
        for number, numbers, end in changed:
            change_body(model, int(number), numbers, end)
        world = settings.world
        if world.roll_rad or world.pitch_rad:
            model.opt.gravity[:] = turned_gravity(model.opt.gravity, world)
        if world.contact_friction != 1.0:
            model.geom_friction[:] *= world.contact_friction
        if changed or any(p.armature_kg_m2 for p in settings.joints):
            mujoco.mj_setConst(model, mujoco.MjData(model))
        return model

    def stiffness(self, settings: RigidSettings) -> tuple[float, ...]:
        """Return the torque of each joint for each radian of its target."""
        return tuple(torque_law(self.kind, p).stiffness for p in settings.joints)

    def _add_springs(self, model: Any, laws: Sequence[TorqueLaw]) -> None:
        for law, joint, dof, place in zip(
            laws, self._joint, self.rigid.speed, self.rigid.position, strict=True
        ):
            own = float(model.jnt_stiffness[joint])
            model.jnt_stiffness[joint] = both = own + law.stiffness
            model.qpos_spring[place] *= own / both if own else 0.0
            model.dof_damping[dof] += law.damping

    def _add_joints(self, model: Any, settings: RigidSettings, laws: Sequence[TorqueLaw]) -> None:
        for at, dof in enumerate(self.rigid.speed):
            p, law = settings.joints[at], laws[at]
            model.dof_armature[dof] += p.armature_kg_m2
            model.dof_damping[dof] += p.viscous_nm_s + law.back_emf
            model.dof_frictionloss[dof] += p.coulomb_nm
            if model.nu:
                model.actuator_gainprm[at, 0] = law.stiffness
                model.actuator_biasprm[at, 1:3] = -law.stiffness, -law.damping
                if math.isfinite(law.limit):
                    model.actuator_forcelimited[at] = 1
                    model.actuator_forcerange[at] = -law.limit, law.limit


def change_body(model: Any, number: int, p: BodyNumbers, end: FloatArray) -> None:
    """Scale a body's mass and inertia, move its centre of mass, and put a weight on it, near its end."""
    model.body_mass[number] *= p.mass_ratio
    model.body_inertia[number] *= p.mass_ratio
    model.body_ipos[number] += p.x_m, p.y_m, p.z_m
    if p.payload_kg <= 0.0:
        return
    mass, centre = float(model.body_mass[number]), model.body_ipos[number].copy()
    turned = Rotation.from_quat(model.body_iquat[number], scalar_first=True).as_matrix()
    about = turned @ np.diag(model.body_inertia[number]) @ turned.T
    total = mass + p.payload_kg
    there = end + np.array([p.payload_x_m, p.payload_y_m, p.payload_z_m])
    joint = (mass * centre + p.payload_kg * there) / total
    for weight, place in ((mass, centre), (p.payload_kg, there)):
        away = place - joint
        about = about + weight * (away @ away * np.eye(3) - np.outer(away, away))
    sizes, axes = np.linalg.eigh(about)
    axes = axes * np.sign(np.linalg.det(axes))
    model.body_mass[number], model.body_ipos[number] = total, joint
    model.body_inertia[number] = sizes
    model.body_iquat[number] = Rotation.from_matrix(axes).as_quat(scalar_first=True)


def turned_gravity(gravity: FloatArray, world: WorldNumbers) -> FloatArray:
    """Return gravity (3,) as a base feels it that stands so turned."""
    turned = Rotation.from_euler("xy", [world.roll_rad, world.pitch_rad])
    return np.asarray(turned.inv().apply(gravity))


def far_ends(rigid: RigidModel) -> FloatArray:
    """Return where a payload would hang on each body, in its frame, (B, 3).

    It is twice as far out as the centre of mass, which is the end of what is evenly thick.
    """
    return np.asarray(2.0 * rigid.model.body_ipos[rigid.body])
