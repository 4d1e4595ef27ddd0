"""An MJCF or URDF with a log, as a machine under diagnosis.

Position loops are simulated from their commands (forward); where a torque or current is logged instead,
it is compared with what the measured motion needs (inverse).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gap.constants import SETTLE_S
from gap.data.check import check_trial
from gap.data.gait_phase import gait_cycle
from gap.delegate import ManyRequest
from gap.interfaces import (
    Cause,
    Channel,
    DataFault,
    Drive,
    Effect,
    Observation,
    check_causes,
)
from gap.machines.mujoco.catalogue import (
    Askable,
    BodyScales,
    JointScales,
    make_catalogue,
    usual_torque,
)
from gap.machines.mujoco.check import (
    check_log,
    refuse_other_torques,
    refuse_other_units,
    speeds_disagree,
)
from gap.machines.mujoco.drive import (
    CURRENT,
    FIRMWARE,
    DriveTable,
    read_drive,
)
from gap.machines.mujoco.edited_model import far_ends
from gap.machines.mujoco.effect_table import (
    CONTROLLER,
    LOAD,
    MOTOR,
    SENSING,
    STAGES,
    MjcfEffect,
)
from gap.machines.mujoco.forward import ForwardModel, ForwardRequest
from gap.machines.mujoco.frames import Frames, frames_of, smoothed
from gap.machines.mujoco.inverse import InverseModel, held_torque, loop_inertia
from gap.machines.mujoco.readings import (
    CURRENT_AT,
    DUTY,
    SHAFT,
    SPEED,
    TORQUE_AT,
    LoopReadings,
    speeds_read,
)
from gap.machines.mujoco.rigid_model import ModelFile, RigidModel, read_rigid_model
from gap.machines.mujoco.settings import RigidSettings, nominal_settings, with_causes
from gap.machines.servo_bench.check import believable
from model.values.arrays import FloatArray, readonly
from record.trial.trial import Trial

TRIALS_REMEMBERED = 64
LEAST_NOISE_RAD = 1e-5
TORQUE_NOISE = 0.002  # of what is usual at a joint
NOISE_RAD_S = 0.05
NOISE_DUTY = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class MachineParts:
    """What a machine is made of: its bodies, how they are driven, and the scales of its effects."""

    rigid: RigidModel
    drive: DriveTable
    torque_nm: FloatArray
    asked: Askable
    kinds: tuple[str, ...]


class MjcfMachine:
    """Implements ``gap.interfaces.Simulator`` for rigid bodies that MuJoCo knows."""

    name = "mjcf"

    def __init__(self, parts: MachineParts, effects: Sequence[MjcfEffect]) -> None:
        rigid, drive = parts.rigid, parts.drive
        self.parts, self.joints, self.bodies = parts, rigid.joints, rigid.bodies
        self.effects: tuple[Effect, ...] = tuple(effects)
        self.stages = STAGES if drive.forward else STAGES[1:]
        self._by_name = {effect.name: effect for effect in effects}
        self._kinds = parts.kinds
        stages = {
            SHAFT: LOAD,
            SPEED: SENSING,
            TORQUE_AT: MOTOR,
            CURRENT_AT: MOTOR,
            DUTY: CONTROLLER,
        }
        units = {SHAFT: "rad", SPEED: "rad/s", TORQUE_AT: "N m", CURRENT_AT: "A", DUTY: ""}
        self.channels = tuple(
            Channel(kind, joint, stages[kind], units[kind])
            for kind in self._kinds
            for joint in self.joints
        )
        self.nominal = nominal_settings(drive.joints, len(rigid.bodies))
        self._frames = lru_cache(maxsize=TRIALS_REMEMBERED)(self._make_frames)
        self._readings = LoopReadings(drive, parts.kinds)
        self._inverse = InverseModel(rigid, drive.kind)
        self._forward = ForwardModel(rigid, drive, self.nominal) if drive.forward else None

    def observe(self, trial: Trial) -> Observation:
        """Put the measured data of a trial on the channels.

        Raises:
            GapError: It is too short, another machine's, or in other units.
        """
        frames = self._frames(trial)
        command, hz = self._command(frames), trial.header.frequency_hz
        values = {SHAFT: frames.shaft_rad - command, SPEED: frames.shaft_rad_s,
                  TORQUE_AT: self._felt(frames.torque_nm, frames),
                  CURRENT_AT: self._felt(frames.current_a, frames), DUTY: frames.pwm}  # fmt: skip
        weight = np.ones((frames.count, len(self.channels)))
        weight[frames.time_s < SETTLE_S] = 0.0
        if (
            self._forward is None
        ):  # at rest a joint's friction may be anything up to where it breaks away
            moving = np.clip(
                np.abs(frames.motion.speed) / frames.motion.still_rad_s - 1.0, 0.0, 1.0
            )
            weight *= np.tile(moving, len(self._kinds))
            weight[-int(np.ceil(SETTLE_S / frames.period_s)) :] = 0.0
        torque = TORQUE_NOISE * self.parts.torque_nm
        noise: dict[str, FloatArray | float] = {
            SHAFT: self._angle_noise(frames),
            SPEED: NOISE_RAD_S,
            DUTY: NOISE_DUTY,
            TORQUE_AT: torque,
            CURRENT_AT: torque / self._per_ampere(),
        }
        shape = (frames.count, len(self.joints))
        return Observation(
            time_s=readonly(frames.time_s.copy()),
            cycle=readonly(gait_cycle(frames.time_s, command, frames.shaft_rad, hz, cranks=False)),
            values=readonly(np.hstack([values[kind] for kind in self._kinds])),
            noise=readonly(np.hstack([np.broadcast_to(noise[k], shape) for k in self._kinds])),
            weight=readonly(weight),
        )

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read with these causes added, (F, C).

        Fed what was measured, joints begin again from the measured state every second.

        Raises:
            GapError: A cause is not of the catalogue, its joints or values do not fit, or the machine as
                its file says cannot be simulated.
        """
        return self.predict_many([(trial, tuple(causes), drive)])[0]

    def predict_many(self, requests: Sequence[ManyRequest]) -> list[FloatArray]:
        """Predict for several trials, sets of causes and drives at once; see ``predict``."""
        for _, causes, _ in requests:
            check_causes(causes, self)
        settings = [
            with_causes(self.nominal, causes, self._by_name, self.joints, self.bodies)
            for _, causes, _ in requests
        ]
        frames = [self._frames(trial) for trial, _, _ in requests]
        drives = [drive for _, _, drive in requests]
        if self._forward is None:
            return [self._needed(f, s) for f, s in zip(frames, settings, strict=True)]
        asked = [ForwardRequest(*one) for one in zip(frames, settings, drives, strict=True)]
        traces = self._forward.traces(asked)
        read = self._readings.values
        return [readonly(read(one, trace)) for one, trace in zip(asked, traces, strict=True)]

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Look for faults of the data themselves."""
        compared = frozenset({"time_s", "shaft", *(f"shaft_{joint}_rad" for joint in self.joints)})
        faults = [believable(fault, trial, compared) for fault in check_trial(trial)]
        known = tuple(fault for fault in faults if fault is not None)
        return (*known, *check_log(trial))

    def _make_frames(self, trial: Trial) -> Frames:
        refuse_other_units(trial, self.parts.rigid)
        frames = frames_of(trial, commanded=self.parts.drive.forward)
        rigid = self.parts.rigid
        if self._forward is not None and not (rigid.floating or rigid.contact):
            needed = self._inverse.torque(frames, self.nominal)
            refuse_other_torques(needed, self._readings.asked_torque(frames, self.nominal))
        return frames

    def _command(self, frames: Frames) -> FloatArray:
        """Commands as they stood at each frame; what an angle is measured from."""
        if self._forward is None:
            return np.zeros((frames.count, len(self.joints)))
        return self._readings.command(frames)

    def _felt(self, values: FloatArray, frames: Frames) -> FloatArray:
        """Torque or current, smoothed as the motion is where it is held against that."""
        return smoothed(values, frames.shaft_rad) if self._forward is None else values

    def _angle_noise(self, frames: Frames) -> FloatArray:
        given = frames.trial.header.noise.shaft_rad
        own = given if np.isfinite(given) and given > 0 else LEAST_NOISE_RAD
        return np.full(len(self.joints), own)

    def _per_ampere(self) -> FloatArray:
        return np.array([p.torque_constant_nm_a for p in self.nominal.joints])

    def _needed(self, frames: Frames, settings: RigidSettings) -> FloatArray:
        """What torques or currents would read along the measured motion."""
        torque = self._inverse.torque(frames, settings)
        scale = np.array([p.torque_scale for p in settings.joints])
        constant = np.array([p.torque_constant_nm_a for p in settings.joints])
        reads = {TORQUE_AT: torque * scale, CURRENT_AT: torque / constant,
                 SPEED: speeds_read(frames.motion.speed, settings)}  # fmt: skip
        predicted: FloatArray = readonly(np.hstack([reads[kind] for kind in self._kinds]))
        return predicted


def make_machine(trials: Sequence[Trial]) -> MjcfMachine:
    """Make the machine of trials that name the same MJCF or URDF and the same drive.

    Raises:
        GapError: The file cannot be compiled, lacks a joint of the log, or [drive] says too little.
    """
    first = trials[0]
    drive, header = read_drive(first), first.header
    file = ModelFile(header.robot_text, header.robot_file or "the model", header.folder)
    rigid = read_rigid_model(file, first.joints, drive.mounting, driven=drive.forward)
    limits = np.fmin([p.limit for p in drive.joints], rigid.limit_nm)
    if drive.kind not in {FIRMWARE, CURRENT}:
        joints = [p._replace(limit=float(m)) for p, m in zip(drive.joints, limits, strict=True)]
        drive = drive._replace(joints=tuple(joints))
    inertia = loop_inertia(rigid)
    torque = usual_torque(held_torque(rigid), inertia, limits)
    kinds = _channel_kinds(drive, trials)
    asked = Askable(rigid.contact, SPEED in kinds, TORQUE_AT in kinds)
    scales = JointScales(torque, np.fmax(inertia, 1e-9))
    effects = make_catalogue(drive, first.joints, scales, _body_scales(rigid), asked)
    return MjcfMachine(MachineParts(rigid, drive, torque, asked, kinds), effects)


def _channel_kinds(drive: DriveTable, trials: Sequence[Trial]) -> tuple[str, ...]:
    """What is compared: angles where commands are simulated, and whatever else was logged."""
    logged: Mapping[str, bool] = {
        SHAFT: drive.forward,
        SPEED: any(speeds_disagree(one) for one in trials),
        TORQUE_AT: any(bool(np.isfinite(one.torque_nm).any()) for one in trials)
        and drive.kind != CURRENT,
        CURRENT_AT: any(bool(np.isfinite(one.current_a).any()) for one in trials)
        and drive.kind in {CURRENT, FIRMWARE},
        DUTY: drive.kind == FIRMWARE and any(bool(np.isfinite(one.pwm).any()) for one in trials),
    }
    return tuple(kind for kind, there in logged.items() if there)


def _body_scales(rigid: RigidModel) -> BodyScales:
    model = rigid.model
    parents = {int(model.body_parentid[one]) for one in rigid.body}
    base = int(rigid.body.min()) if rigid.floating else -1
    carriers = tuple(
        name
        for name, one in zip(rigid.bodies, rigid.body, strict=True)
        if int(one) not in parents or int(one) == base
    )
    size = np.fmax(2.0 * np.linalg.norm(far_ends(rigid), axis=1) / 2.0, 0.02)
    return BodyScales(rigid.bodies, np.asarray(model.body_mass[rigid.body]), size, carriers)
