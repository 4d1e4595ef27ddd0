"""Commands through drive and rigid bodies: rollouts of many settings at once, remembered tree by tree.

Bodies of one kinematic tree do not act on those of another where the base is fixed and nothing touches.
So settings that differ in other trees share a run, and what one tree did is remembered by its own numbers.
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gap.interfaces import Drive
from gap.machines.mujoco.drive import DriveTable, JointNumbers, pursuing, torque_law
from gap.machines.mujoco.edited_model import ModelEditor
from gap.machines.mujoco.frames import Frames
from gap.machines.mujoco.inverse import loop_inertia
from gap.machines.mujoco.rigid_model import RigidModel
from gap.machines.mujoco.rollouts import RolloutPool, Run
from gap.machines.mujoco.run_parts import RunParts, RunSegments
from gap.machines.mujoco.settings import RigidSettings, WorldNumbers
from model.errors import GapError
from model.values.arrays import BoolArray, FloatArray, IntArray

# A run fed what was measured begins again after so long: many times a loop's own memory, so that where a
# joint comes to rest counts, and not how it began.
SEGMENT_S = 1.0
MOST_S = 16.0  # of a trial, that is simulated in segments; they lie evenly over a longer one
LARGEST_STEP_S = 0.0025
SHORTEST_STEP_S = 0.0002
STIFF = 0.4  # step times the fastest frequency of a loop, at most
REMEMBERED_BYTES = 200_000_000
TRIALS_REMEMBERED = 64
BROKEN_RAD = 10.0  # error of a candidate that the simulator could not follow

TreeKey = tuple[int, Drive, int, object]


@dataclass(frozen=True, slots=True)
class ForwardRequest:
    """One prediction: frames of a trial, settings, and what feeds them."""

    frames: Frames
    settings: RigidSettings
    drive: Drive


Asked = tuple[TreeKey, ForwardRequest]
# What is asked of each tree in one run, one of the requests, and the settings of the run.
Merged = tuple[Sequence[Asked | None], ForwardRequest, RigidSettings]


@dataclass(frozen=True, slots=True, eq=False)
class JointTraces:
    """Angle and speed of J joints in a simulation, NaN where none was made: tree by tree.

    Attributes:
        parts: Angles and speeds of the joints of each tree, (2, F, joints of it).
        order: Where each joint lies among those of the parts one behind the other, (J,).
    """

    parts: Sequence[FloatArray]
    order: IntArray

    @property
    def angle(self) -> FloatArray:
        """Angle of each joint, (F, J)."""
        return np.hstack([part[0] for part in self.parts])[:, self.order]

    @property
    def speed(self) -> FloatArray:
        """Speed of each joint, (F, J)."""
        return np.hstack([part[1] for part in self.parts])[:, self.order]


class ForwardModel:
    """Simulates a machine whose joints follow commands."""

    def __init__(self, rigid: RigidModel, drive: DriveTable, nominal: RigidSettings) -> None:
        self.rigid, self.drive, self.nominal = rigid, drive, nominal
        self._editor = ModelEditor(rigid, drive.kind)
        self._pool = RolloutPool()
        self._known: OrderedDict[TreeKey, FloatArray] = OrderedDict()
        self._bytes = 0
        self._inertia = loop_inertia(rigid)
        # joints and bodies of each tree
        self._places = [
            [np.flatnonzero(of == tree).tolist() for of in (rigid.joint_tree, rigid.body_tree)]
            for tree in range(rigid.trees)
        ]
        joints = [at for own, _ in self._places for at in own]
        self._order = np.argsort(joints)
        self._runs = RunParts(rigid, drive)
        self._parts = lru_cache(maxsize=TRIALS_REMEMBERED)(self._segments)

    def traces(self, requests: Sequence[ForwardRequest]) -> list[JointTraces]:
        """Simulate all requests, those that differ in other trees in one run.

        Raises:
            GapError: The machine as its file says cannot be simulated.
        """
        keys = [[self._key(r, tree) for tree in range(self.rigid.trees)] for r in requests]
        fresh: dict[tuple[int, Drive, WorldNumbers], list[dict[TreeKey, ForwardRequest]]] = {}
        for request, own in zip(requests, keys, strict=True):
            group = (id(request.frames), request.drive, request.settings.world)
            per_tree = fresh.setdefault(group, [{} for _ in range(self.rigid.trees)])
            for tree, key in enumerate(own):
                if key not in self._known:
                    per_tree[tree][key] = request
        made: dict[TreeKey, FloatArray] = {}
        for per_tree in fresh.values():
            made |= self._run(per_tree)
        traces = [
            JointTraces(
                [made[key] if key in made else self._known[key] for key in own], self._order
            )
            for own in keys
        ]
        for key, values in made.items():
            self._known[key] = values
            self._bytes += values.nbytes
        for own in keys:
            for key in own:
                self._known.move_to_end(key)
        while self._bytes > REMEMBERED_BYTES:
            self._bytes -= self._known.popitem(last=False)[1].nbytes
        return traces

    def _key(self, request: ForwardRequest, tree: int) -> TreeKey:
        """What a tree's motion depends on; how its readings are scaled is not part of it."""
        s = request.settings
        own, carried = self._places[tree]
        joints = tuple(_moving(s.joints[at]) for at in own)
        bodies = tuple(s.bodies[at] for at in carried)
        return id(request.frames), request.drive, tree, (joints, bodies, s.world)

    def _run(self, per_tree: Sequence[dict[TreeKey, ForwardRequest]]) -> dict[TreeKey, FloatArray]:
        """Simulate what is asked of each tree of one trial under one drive in one world."""
        queues = [list(asked.items()) for asked in per_tree]
        merged: list[Merged] = []
        for at in range(max(map(len, queues), default=0)):
            own: list[Asked | None] = [queue[at] if at < len(queue) else None for queue in queues]
            first = next(one for one in own if one is not None)[1]
            merged.append((own, first, self._merged(own, first.settings)))
        if not merged:
            return {}
        frames, drive = merged[0][1].frames, merged[0][1].drive
        segments = self._parts(frames, drive)
        if segments is None:
            nothing = np.full((2, frames.count, len(self.rigid.joints)), np.nan)
            return {
                one[0]: nothing[:, :, self.rigid.joint_tree == tree]
                for wanted, _, _ in merged
                for tree, one in enumerate(wanted)
                if one is not None
            }
        every = self.steps(frames.period_s)
        made: dict[TreeKey, FloatArray] = {}
        while merged:
            runs = [self._made(frames, settings, segments, every) for _, _, settings in merged]
            states, sound = self._pool.states(runs, every)
            again = []
            for number, (wanted, _, settings) in enumerate(merged):
                asked = [tree for tree, one in enumerate(wanted) if one is not None]
                if not sound[number].all():
                    if settings == self.nominal:
                        self._refuse(frames, segments, sound[number])
                    if len(asked) > 1:  # each by itself, so that only the one that broke it pays
                        again += self._apart(wanted)
                        continue
                whole = self._unrolled(frames, segments, states[number], sound[number])
                for tree in asked:
                    one = wanted[tree]
                    assert one is not None
                    made[one[0]] = whole[:, :, self.rigid.joint_tree == tree]
            merged = again
        return made

    def _apart(self, own: Sequence[Asked | None]) -> list[Merged]:
        """RigidSettings that shared a run, each in a run of its own."""
        listed: list[Merged] = []
        for tree, one in enumerate(own):
            if one is not None:
                alone = [one if at == tree else None for at in range(len(own))]
                listed.append((alone, one[1], self._merged(alone, one[1].settings)))
        return listed

    def _merged(self, own: Sequence[Asked | None], first: RigidSettings) -> RigidSettings:
        """RigidSettings in which each tree has those that are asked of it; nominal where none are."""
        joints, bodies = list(self.nominal.joints), list(self.nominal.bodies)
        for tree, one in enumerate(own):
            if one is None:
                continue
            own_joints, own_bodies = self._places[tree]
            for at in own_joints:
                joints[at] = one[1].settings.joints[at]
            for at in own_bodies:
                bodies[at] = one[1].settings.bodies[at]
        return RigidSettings(tuple(joints), tuple(bodies), first.world)

    def steps(self, period_s: float) -> int:
        """Return how many steps a frame takes: as many as the stiffest loop needs."""
        stiffness = [torque_law(self.drive.kind, p).stiffness for p in self.nominal.joints]
        more = np.array([p.armature_kg_m2 for p in self.nominal.joints])
        fastest = float(np.sqrt(np.max(np.array(stiffness) / (self._inertia + more))))
        longest = min(LARGEST_STEP_S, STIFF / max(fastest, 1e-9))
        if self.rigid.contact:
            longest = min(longest, float(self.rigid.model.opt.timestep))
        return int(np.ceil(period_s / max(longest, SHORTEST_STEP_S) - 1e-9))

    def _segments(self, frames: Frames, drive: Drive) -> RunSegments | None:
        """Where runs begin; None where nothing says in what state."""
        last = max(frames.count - 1, 1)
        if drive is Drive.COMMAND:
            return RunSegments(np.zeros(1, dtype=np.int64), last)
        if self.rigid.floating and not self._runs.base(frames).measured:
            return None
        length = min(max(2, round(SEGMENT_S / frames.period_s)), last)
        first = np.arange(0, max(last - length // 2, 1), length)
        most = max(1, round(MOST_S / (length * frames.period_s)))
        if len(first) > most:
            first = first[np.round(np.linspace(0, len(first) - 1, most)).astype(np.int64)]
        return RunSegments(first, length)

    def _made(
        self, frames: Frames, settings: RigidSettings, segments: RunSegments, every: int
    ) -> Run:
        model = self._editor.edited(settings)
        model.opt.timestep = frames.period_s / every
        pursued = tuple(pursuing(p, self.drive) for p in settings.joints)
        stiffness = () if model.nu else self._editor.stiffness(settings)
        first, targets = self._runs.pull(frames, pursued, segments, every, stiffness)
        qpos, qvel = self._runs.starts(frames, settings, segments.first, first)
        return Run(
            model, qpos, qvel, targets, self._runs.friction(frames, settings, segments.first)
        )

    def _unrolled(
        self, frames: Frames, segments: RunSegments, states: FloatArray, sound: BoolArray
    ) -> FloatArray:
        """Angles and speeds of all joints on all frames, (2, F, J); NaN in those of no segment.

        Where two segments meet, it is the earlier one that says how far it went.
        """
        nq, joints = int(self.rigid.model.nq), len(self.rigid.joints)
        out = np.full((2, frames.count, joints), np.nan)
        rows = segments.first[:, None] + np.arange(segments.length + 1)
        angle = states[:, :, self.rigid.position] + np.where(sound, 0.0, BROKEN_RAD)[:, :, None]
        whole = np.stack([angle, states[:, :, nq + self.rigid.speed]])
        for segment in reversed(range(len(rows))):
            inside = rows[segment] < frames.count
            out[:, rows[segment][inside]] = whole[:, segment, inside]
        return out

    def _refuse(self, frames: Frames, segments: RunSegments, sound: BoolArray) -> None:
        segment, frame = np.argwhere(~sound)[0]
        at_s = (int(segments.first[segment]) + int(frame)) * frames.period_s
        raise GapError(
            f"the model explodes {at_s:.2f} s after the start, with no effect added: check masses, "
            "inertias and gains (units?), or give it a smaller timestep"
        )


def _moving(p: JointNumbers) -> JointNumbers:
    """A joint without how its readings are scaled."""
    if p.speed_scale == 1.0 and p.torque_scale == 1.0:
        return p
    return p._replace(speed_scale=1.0, torque_scale=1.0)
