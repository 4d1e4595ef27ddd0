"""Many rollouts at once, by ``mujoco.rollout`` and its threads: one model a run, in segments or whole.

A run whose state is no longer finite, or which MuJoCo gave up, keeps its last state: the candidate that
broke it is far from what was measured, and pays for that.
"""

import copy
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from gap.machines.mujoco.quiet import quiet
from model.values.arrays import BoolArray, FloatArray, IntArray

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
TARGETS, FORCES = mujoco.mjtState.mjSTATE_CTRL, mujoco.mjtState.mjSTATE_QFRC_APPLIED
THREADS = min(os.cpu_count() or 1, 4)
BATCH_BYTES = 64_000_000
BEYOND = 1e4  # rad, rad/s, m: a state that is no machine's


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One run of S segments, each of as many steps.

    Attributes:
        model: Its own, edited.
        qpos: Positions at the start of each segment, (S, nq).
        qvel: Speeds there, (S, nv).
        target: What drives the actuators in each step, (S, steps, nu); forces on all degrees of freedom
            where the model has none, (S, steps, nv).
        friction: None, or what is added to the ``frictionloss`` of every degree of freedom from a frame on,
            (nv,), given the segment, the frame in it and the speeds there.
    """

    model: Any
    qpos: FloatArray
    qvel: FloatArray
    target: FloatArray
    friction: Callable[[int, int, FloatArray], FloatArray] | None = None

    @property
    def steps(self) -> int:
        """Steps of a segment."""
        return int(self.target.shape[1])


class RolloutPool:
    """Runs rollouts on threads that are started when they are first needed, again in a forked process."""

    def __init__(self, threads: int = THREADS) -> None:
        self._threads = threads
        self._pool: Any = None
        # by the number of actuators, which tells models apart
        self._data: dict[int, list[Any]] = {}
        self._process = self.size = 0
        self._room: FloatArray = np.empty(0)

    def states(self, runs: Sequence[Run], every: int) -> tuple[FloatArray, BoolArray]:
        """Roll runs out that have equally many segments and steps.

        Args:
            runs: R runs.
            every: Steps from one frame to the next.

        Returns:
            State at every frame of every segment, the first included, (R, S, frames, nq + nv), and whether
            it is one that the run reached, (R, S, frames).
        """
        segments, steps = len(runs[0].qpos), runs[0].steps
        if not self.size:
            self.size = mujoco.mj_stateSize(runs[0].model, STATE)
        frames = steps // every + 1
        out = np.stack([np.hstack([run.qpos, run.qvel]) for run in runs])[:, :, None]
        out = np.repeat(out, frames, axis=2)
        most = max(1, BATCH_BYTES // (8 * segments * steps * self.size))
        kinds: dict[tuple[bool, int], list[int]] = {}
        for number, run in enumerate(runs):
            kinds.setdefault((run.friction is None, int(run.model.nu)), []).append(number)
        for (plain, _), own in kinds.items():
            rolled = self._whole if plain else self._by_frames
            for first in range(0, len(own), most):
                batch = own[first : first + most]
                out[batch, :, 1:] = rolled([runs[i] for i in batch], every)
        sound: BoolArray = np.logical_and.reduce(np.isfinite(out) & (np.abs(out) < BEYOND), axis=3)
        if sound.all():
            return out, sound
        sound = np.asarray(np.logical_and.accumulate(sound, axis=2))
        last = np.maximum.accumulate(np.where(sound, np.arange(frames), 0), axis=2)
        return np.take_along_axis(out, last[..., None], axis=2), sound

    def _whole(self, runs: Sequence[Run], every: int) -> FloatArray:
        segments = len(runs[0].qpos)
        models = [run.model for run in runs for _ in range(segments)]
        states = self._rolled(models, self._starts(runs), np.concatenate([r.target for r in runs]))
        width = 1 + runs[0].qpos.shape[1] + runs[0].qvel.shape[1]
        reached = states[:, every - 1 :: every, :width]
        stopped = _stopped(reached[:, :, 0], models[0], every * np.arange(1, reached.shape[1] + 1))
        there = reached[:, :, 1:].reshape(len(runs), segments, reached.shape[1], width - 1)
        if stopped.any():
            there[stopped.reshape(there.shape[:3])] = np.nan
        return there

    def _by_frames(self, runs: Sequence[Run], every: int) -> FloatArray:
        """Friction that follows load or speed is set again in every frame."""
        (segments, nq), nv = runs[0].qpos.shape, runs[0].qvel.shape[1]
        owners = [(run, segment) for run in runs for segment in range(segments)]
        models = [copy.copy(run.model) for run, _ in owners]
        target = np.concatenate([run.target for run in runs])
        states, reached = self._starts(runs), []
        for frame in range(runs[0].steps // every):
            for at, (run, segment) in enumerate(owners):
                assert run.friction is not None
                more = run.friction(segment, frame, states[at, 1 + nq : 1 + nq + nv])
                models[at].dof_frictionloss[:] = run.model.dof_frictionloss + more
            there = self._rolled(models, states, target[:, frame * every : (frame + 1) * every])
            gone = _stopped(there[:, -1, 0], models[0], every * (frame + 1))
            states = np.where(gone[:, None], np.nan, there[:, -1])
            reached.append(states[:, 1 : 1 + nq + nv])
            states = np.where(gone[:, None], 0.0, states)
        return np.stack(reached, axis=1).reshape(len(runs), segments, len(reached), nq + nv)

    def _starts(self, runs: Sequence[Run]) -> FloatArray:
        """States before the first step of each segment of each run."""
        rows = np.concatenate([np.hstack([run.qpos, run.qvel]) for run in runs])
        packed = np.zeros((len(rows), self.size))
        packed[:, 1 : 1 + rows.shape[1]] = rows
        return packed

    def _rolled(self, models: list[Any], first: FloatArray, target: FloatArray) -> FloatArray:
        """Roll out; the states are overwritten by the next call, (runs, steps, size)."""
        if self._pool is None or self._process != os.getpid():
            self._pool = rollout.Rollout(nthread=self._threads)
            self._data, self._process = {}, os.getpid()
        wanted = len(models) * target.shape[1] * self.size
        if self._room.size < wanted:
            self._room = np.empty(wanted)  # fresh memory for each call would take a twentieth of it
        room = self._room[:wanted].reshape(len(models), target.shape[1], self.size)
        driven = int(models[0].nu)
        if driven not in self._data:
            self._data[driven] = [mujoco.MjData(models[0]) for _ in range(self._threads)]
        with quiet():
            states, _ = self._pool.rollout(
                models, self._data[driven], np.ascontiguousarray(first), np.ascontiguousarray(target),
                nstep=target.shape[1], control_spec=int(TARGETS if driven else FORCES), state=room,
            )  # fmt: skip
        return np.asarray(states)


def _stopped(time_s: FloatArray, model: Any, steps: IntArray | int) -> BoolArray:
    """Whether MuJoCo has given runs up: their time is not that of so many steps."""
    step_s = float(model.opt.timestep)
    stopped: BoolArray = ~(np.abs(time_s - step_s * steps) < 0.5 * step_s)
    return stopped
