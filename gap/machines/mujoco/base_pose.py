"""Where the base of a machine is when a run begins: fixed, as measured, or standing as it came to rest."""

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from gap.data.even_grid import on_times
from gap.machines.mujoco.frames import Frames
from gap.machines.mujoco.rigid_model import RigidModel
from model.values.arrays import FloatArray, IntArray

SETTLE_S = 1.0
STAND_STIFFNESS = (
    50.0  # of what holds the joints while the base comes to rest, times inertia and s^-2
)


class BaseStarts:
    """Positions and speeds of everything but the log's joints, for runs of one trial.

    ``measured`` is whether the pose of a free base was measured; without, it is dropped onto its feet.
    """

    def __init__(self, rigid: RigidModel, frames: Frames) -> None:
        self._rigid, self._frames = rigid, frames
        trial = frames.trial
        at_s = frames.time_s + trial.time_s[0]
        place = on_times(trial.time_s, trial.body_position_m, at_s)
        angles = on_times(trial.time_s, trial.body_angles_rad, at_s)
        self.measured = bool(np.isfinite(place).all() and np.isfinite(angles).all())
        if rigid.floating and self.measured:
            self._place = place
            self._turn = Rotation.from_euler("ZYX", angles[:, ::-1])

    def at(self, segments: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return positions (S, nq) and speeds (S, nv) where segments begin, without the log's joints."""
        model = self._rigid.model
        qpos = np.tile(model.qpos0, (len(segments), 1))
        qvel = np.zeros((len(segments), model.nv))
        if not self._rigid.floating:
            return qpos, qvel
        joint = int(np.flatnonzero(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE))[0])
        first, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        if not self.measured:
            qpos[:, first : first + 7] = self._at_rest(first)
            return qpos, qvel
        period = self._frames.period_s
        qpos[:, first : first + 3] = self._place[segments]
        qpos[:, first + 3 : first + 7] = self._turn[segments].as_quat(scalar_first=True)
        qvel[:, dof : dof + 3] = np.gradient(self._place, period, axis=0)[segments]
        ahead = np.minimum(segments + 1, self._frames.count - 1)
        turned = self._turn[segments].inv() * self._turn[ahead]
        qvel[:, dof + 3 : dof + 6] = turned.as_rotvec() / period
        return qpos, qvel

    def _at_rest(self, first: int) -> FloatArray:
        """Where the base comes to rest on the ground while the joints are held as first measured."""
        rigid = self._rigid
        model, data = rigid.model, rigid.data()
        start = np.nan_to_num(self._frames.motion.angle[0])
        data.qpos[rigid.position] = start
        mujoco.mj_forward(model, data)
        if not rigid.contact:
            return np.array(data.qpos[first : first + 7])
        data.qpos[first + 2] += 0.001 - min(_lowest(model, data), np.inf)
        for _ in range(round(SETTLE_S / float(model.opt.timestep))):
            mujoco.mj_step(model, data)
            data.qpos[rigid.position] = start
            data.qvel[rigid.speed] = 0.0
        return np.array(data.qpos[first : first + 7])


def _lowest(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Height of the lowest point of what moves, by the spheres about its shapes."""
    moving = model.body_weldid[model.geom_bodyid] > 0
    touching = moving & ((model.geom_contype | model.geom_conaffinity) > 0)
    heights = data.geom_xpos[touching, 2] - model.geom_rbound[touching]
    return float(np.min(heights, initial=np.inf)) if touching.any() else 0.0
