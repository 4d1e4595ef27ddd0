"""The torque that a motion needs: inverse dynamics along measured angles, and friction on top.

Where no command is logged, a measured torque or current is held against it. Friction, armature and the
drive act outside MuJoCo here, because their laws hold along any motion; masses and gravity act in it.
"""

import copy
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from gap.machines.mujoco.drive import JointNumbers
from gap.machines.mujoco.edited_model import ModelEditor
from gap.machines.mujoco.frames import Frames
from gap.machines.mujoco.rigid_model import RigidModel
from gap.machines.mujoco.settings import BodyNumbers, RigidSettings, WorldNumbers
from model.values.arrays import FloatArray

POSES = 64
REMEMBERED = 64


def bias_torque(rigid: RigidModel, frames: Frames) -> FloatArray:
    """Return the torque of gravity and speed at each joint along the measured motion, (F, J)."""
    motion = frames.motion
    model = plain(copy.copy(rigid.model))
    return _needed(rigid, model, motion.angle, motion.speed, np.zeros(motion.angle.shape))


def plain(model: Any) -> Any:
    """Return a model whose joints have neither friction nor springs nor limits nor actuators."""
    off = mujoco.mjtDisableBit
    model.opt.disableflags |= int(
        off.mjDSBL_CONSTRAINT | off.mjDSBL_ACTUATION | off.mjDSBL_DAMPER | off.mjDSBL_SPRING
    )
    return model


def _needed(
    rigid: RigidModel, model: Any, angle: FloatArray, speed: FloatArray, acceleration: FloatArray
) -> FloatArray:
    data = mujoco.MjData(model)
    out = np.full(angle.shape, np.nan)
    position, dof = rigid.position, rigid.speed
    known = np.isfinite(angle).all(axis=1)
    for row in np.flatnonzero(known):
        data.qpos[position], data.qvel[dof], data.qacc[dof] = (
            angle[row],
            speed[row],
            acceleration[row],
        )
        mujoco.mj_inverse(model, data)
        out[row] = data.qfrc_inverse[dof]
    return out


class InverseModel:
    """What joints need along measured motions, for many settings."""

    def __init__(self, rigid: RigidModel, kind: str) -> None:
        self.rigid = rigid
        self._editor = ModelEditor(rigid, kind)
        self._bodies = lru_cache(maxsize=REMEMBERED)(self._of_bodies)

    def torque(self, frames: Frames, settings: RigidSettings) -> FloatArray:
        """Return the torque that each joint's drive has to give along a trial, (F, J)."""
        motion, model = frames.motion, self.rigid.model
        offsets = tuple(p.encoder_offset_rad for p in settings.joints)
        world = settings.world._replace(contact_friction=1.0, stamp_delay_s=0.0, clock_ratio=1.0)
        needed = self._bodies(frames, settings.bodies, world, offsets).copy()
        for at, (dof, p) in enumerate(zip(self.rigid.speed, settings.joints, strict=True)):
            speed = motion.speed[:, at]
            still = max(float(motion.still_rad_s[at]), 1e-9)
            friction = dry_friction(p, speed, needed[:, at]) + float(model.dof_frictionloss[dof])
            needed[:, at] += p.armature_kg_m2 * motion.acceleration[:, at]
            needed[:, at] += (p.viscous_nm_s + float(model.dof_damping[dof])) * speed
            needed[:, at] += friction * np.tanh(speed / still)
        return needed

    def _of_bodies(
        self,
        frames: Frames,
        bodies: tuple[BodyNumbers, ...],
        world: WorldNumbers,
        offsets: tuple[float, ...],
    ) -> FloatArray:
        """What rigid bodies need, with the file's own armature and springs left to MuJoCo."""
        still = (JointNumbers(),) * len(self.rigid.joints)
        model = plain(self._editor.edited(RigidSettings(still, bodies, world)))
        motion = frames.motion
        return _needed(self.rigid, model, motion.angle - offsets, motion.speed, motion.acceleration)


def dry_friction(p: JointNumbers, speed: FloatArray, load: FloatArray) -> FloatArray:
    """Return how large dry friction is at each speed and load, never negative, (F,)."""
    stick = p.stribeck_nm * np.exp(-np.abs(speed) / p.stribeck_rad_s)
    return np.asarray(p.coulomb_nm + stick + p.load_friction * np.abs(load))


def poses_of(rigid: RigidModel) -> FloatArray:
    """Return poses over the ranges of the joints, a turn where there is none, (P, J); always the same."""
    model = rigid.model
    number = model.dof_jntid[rigid.speed]
    limited = model.jnt_limited[number].astype(bool)
    low = np.where(limited, model.jnt_range[number, 0], -np.pi)
    high = np.where(limited, model.jnt_range[number, 1], np.pi)
    rng = np.random.default_rng(0)
    return np.asarray(rng.uniform(low, high, size=(POSES, len(number))))


def held_torque(rigid: RigidModel) -> FloatArray:
    """Return the torque that holds each joint against gravity in its worst pose of many, (J,)."""
    poses, still = poses_of(rigid), np.zeros((POSES, len(rigid.joints)))
    held = _needed(rigid, plain(copy.copy(rigid.model)), poses, still, still)
    return np.asarray(np.abs(held).max(axis=0))


def loop_inertia(rigid: RigidModel) -> FloatArray:
    """Return the inertia that each joint feels, the median over its poses, (J,)."""
    data, poses = rigid.data(), poses_of(rigid)
    inertia = np.zeros((POSES, len(rigid.joints)))
    full = np.zeros((rigid.model.nv, rigid.model.nv))
    for row, pose in enumerate(poses):
        data.qpos[rigid.position] = pose
        mujoco.mj_forward(rigid.model, data)
        mujoco.mj_fullM(rigid.model, data, full)
        inertia[row] = np.diag(full)[rigid.speed]
    return np.asarray(np.median(inertia, axis=0))
