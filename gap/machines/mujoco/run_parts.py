"""What a run begins with and what drives it: states, targets or forces, friction that follows load."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gap.machines.mujoco.base_pose import BaseStarts
from gap.machines.mujoco.drive import DriveTable, JointNumbers, torque_law
from gap.machines.mujoco.frames import Frames, targets_of
from gap.machines.mujoco.inverse import bias_torque
from gap.machines.mujoco.rigid_model import RigidModel
from gap.machines.mujoco.settings import RigidSettings
from model.values.arrays import FloatArray, IntArray

TARGETS_REMEMBERED = 256
PULLS_REMEMBERED = 8


@dataclass(frozen=True, slots=True, eq=False)
class RunSegments:
    """First frames of S segments, (S,), and how many frames each is long."""

    first: IntArray
    length: int


class RunParts:
    """Makes what runs of one machine need, and remembers it."""

    def __init__(self, rigid: RigidModel, drive: DriveTable) -> None:
        self._rigid, self._drive = rigid, drive
        self.base = lru_cache(maxsize=8)(lambda frames: BaseStarts(rigid, frames))
        self.pull = lru_cache(maxsize=PULLS_REMEMBERED)(self._make_pull)
        self._load = lru_cache(maxsize=8)(lambda frames: np.abs(bias_torque(rigid, frames)))
        self._target = lru_cache(maxsize=TARGETS_REMEMBERED)(
            lambda frames, at, p, every: targets_of(frames, drive, at, p, every)
        )

    def _make_pull(
        self, frames: Frames, pursued: tuple[JointNumbers, ...], segments: RunSegments,
        every: int, stiffness: tuple[float, ...],
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """Targets of all joints where segments begin, (S, J), and what drives a run (see ``Run``)."""
        rows = np.arange(segments.length * every)[None] + segments.first[:, None] * every
        columns = [self._target(frames, at, p, every) for at, p in enumerate(pursued)]
        rows = np.minimum(rows, len(columns[0]) - 1)
        targets = np.stack([column[rows] for column in columns], axis=2)
        if not stiffness:
            return targets[:, 0], targets
        forces = np.zeros((*rows.shape, int(self._rigid.model.nv)))
        forces[:, :, self._rigid.speed] = targets * stiffness
        return targets[:, 0], forces

    def starts(
        self, frames: Frames, settings: RigidSettings, at_frames: IntArray, targets: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """State of all joints and of the base at some frames, with the targets there, (S, J)."""
        qpos, qvel = self.base(frames).at(at_frames)
        moving = frames.motion.speed[at_frames]
        seen = frames.motion.angle[at_frames] + settings.world.stamp_delay_s * moving
        offset = np.array([p.encoder_offset_rad for p in settings.joints])
        scale = np.array([p.encoder_scale for p in settings.joints])
        angle = (seen - offset) / scale
        for at, p in enumerate(settings.joints):
            if p.compliance_rad_nm > 0.0:
                law = torque_law(self._drive.kind, p._replace(compliance_rad_nm=0.0))
                asked = law.asked(targets[:, at], angle[:, at], moving[:, at])
                angle[:, at] -= p.compliance_rad_nm * asked
        qpos[:, self._rigid.position] = np.where(np.isfinite(angle), angle, targets)
        qvel[:, self._rigid.speed] = np.nan_to_num(moving) / scale
        return qpos, qvel

    def friction(
        self, frames: Frames, settings: RigidSettings, first: IntArray
    ) -> Callable[[int, int, FloatArray], FloatArray] | None:
        """Friction that follows load and speed; None where there is none."""
        loaded = np.array([p.load_friction for p in settings.joints])
        stick = np.array([p.stribeck_nm for p in settings.joints])
        if not loaded.any() and not stick.any():
            return None
        slow = np.array([p.stribeck_rad_s for p in settings.joints])
        dry = loaded * self._load(frames)
        rigid, last = self._rigid, frames.count - 1

        def added(segment: int, frame: int, speeds: FloatArray) -> FloatArray:
            out = np.zeros(rigid.model.nv)
            now = dry[min(int(first[segment]) + frame, last)]
            out[rigid.speed] = now + stick * np.exp(-np.abs(speeds[rigid.speed]) / slow)
            return out

        return added
