"""What sensors read of a simulation: angles with the encoder's faults, speeds, torque, current and duty.

Only what is compared is computed; the rest would be most of the work of a prediction that is remembered.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from gap.interfaces import Drive
from gap.machines.mujoco.drive import DriveTable, JointNumbers, pursuing, torque_law
from gap.machines.mujoco.forward import ForwardRequest, JointTraces
from gap.machines.mujoco.frames import Frames, targets_of
from gap.machines.mujoco.settings import RigidSettings
from model.motion.filters import at_times
from model.values.arrays import FloatArray

TARGETS_REMEMBERED = 256
TRIALS_REMEMBERED = 64
SHAFT, SPEED, TORQUE_AT, CURRENT_AT, DUTY = "shaft_error", "speed", "torque", "current", "duty"


class LoopReadings:
    """Reads simulations of a machine whose joints follow commands; ``kinds`` are read, in their order."""

    def __init__(self, drive: DriveTable, kinds: Sequence[str]) -> None:
        self.drive, self.kinds = drive, tuple(kinds)
        self._pulls = bool({*kinds} - {SHAFT, SPEED})
        self._target: Callable[[Frames, int, JointNumbers], FloatArray] = lru_cache(
            maxsize=TARGETS_REMEMBERED
        )(self._make_target)
        self.command: Callable[[Frames], FloatArray] = lru_cache(maxsize=TRIALS_REMEMBERED)(
            standing_command
        )

    def values(self, one: ForwardRequest, trace: JointTraces) -> FloatArray:
        """Return what the sensors would read, (F, C)."""
        joints, angle = one.settings.joints, trace.angle
        shaft = _each(joints, "encoder_scale") * angle + _each(joints, "encoder_offset_rad")
        gives = _each(joints, "compliance_rad_nm")
        if gives.any():
            shaft += gives * self._pull(one, angle, trace.speed)
        shaft = self._stamped(shaft, trace, one)
        reads = {SHAFT: np.subtract(shaft, self.command(one.frames), out=shaft)}
        if self.kinds == (SHAFT,):
            return reads[SHAFT]
        measured = one.drive is Drive.MEASURED
        speed = one.frames.motion.speed if measured else trace.speed
        reads[SPEED] = speeds_read(speed, one.settings)
        if self._pulls:
            if measured:  # what the loop would do about the measured angle
                angle = one.frames.motion.angle - _each(joints, "encoder_offset_rad")
                angle = angle / _each(joints, "encoder_scale")
            reads |= self._loop_reads(one, self._pull(one, angle, speed), speed)
        return np.asarray(np.hstack([reads[kind] for kind in self.kinds]))

    def _loop_reads(
        self, one: ForwardRequest, pull: FloatArray, speed: FloatArray
    ) -> dict[str, FloatArray]:
        """What sensors of the drive read of the torque that each loop asks for, (F, J) each."""
        joints = one.settings.joints
        back_emf = np.array([torque_law(self.drive.kind, p).back_emf for p in joints])
        left, constant = pull - back_emf * speed, _each(joints, "torque_constant_nm_a")
        stall = constant * _each(joints, "supply_v") / _each(joints, "resistance_ohm")
        return {
            TORQUE_AT: left * _each(joints, "torque_scale"),
            CURRENT_AT: left / constant,
            DUTY: pull / np.where(stall > 0, stall, np.nan),
        }

    def asked_torque(self, frames: Frames, settings: RigidSettings) -> FloatArray:
        """Return the torque that each loop asks for along the measured motion, (F, J)."""
        motion = frames.motion
        return self._pull(
            ForwardRequest(frames, settings, Drive.MEASURED), motion.angle, motion.speed
        )

    def _pull(self, one: ForwardRequest, angle: FloatArray, speed: FloatArray) -> FloatArray:
        """Torque that each loop asks for, (F, J)."""
        joints = one.settings.joints
        laws = [torque_law(self.drive.kind, p) for p in joints]
        stiffness, damping, limit = np.array([law[:3] for law in laws]).T
        target = np.column_stack([
            self._target(one.frames, at, pursuing(p, self.drive)) for at, p in enumerate(joints)
        ])  # fmt: skip
        pull: FloatArray = np.clip(stiffness * (target - angle) - damping * speed, -limit, limit)
        return pull

    def _make_target(self, frames: Frames, at: int, p: JointNumbers) -> FloatArray:
        target = targets_of(frames, self.drive, at, p, 1)
        return np.append(target, target[-1])

    def _stamped(self, angle: FloatArray, trace: JointTraces, one: ForwardRequest) -> FloatArray:
        """Angles as they are stamped; within segments by their speed, because each begins again."""
        world, time_s = one.settings.world, one.frames.time_s
        if world.clock_ratio == 1.0 and world.stamp_delay_s == 0.0:
            return angle
        late_s = world.clock_ratio * time_s - world.stamp_delay_s - time_s
        if one.drive is Drive.MEASURED:
            return np.asarray(angle + trace.speed * late_s[:, None])
        return at_times(time_s, angle, time_s + late_s)


def _each(joints: Sequence[JointNumbers], name: str) -> FloatArray:
    """One number of every joint, (J,)."""
    return np.array([getattr(p, name) for p in joints])


def standing_command(frames: Frames) -> FloatArray:
    """Return commands as they stood at each frame, (F, J); what an angle is measured from."""
    row = np.searchsorted(frames.command_s, frames.time_s + 1e-9, side="right") - 1
    return np.asarray(frames.command_rad[np.clip(row, 0, None)])


def speeds_read(speed: FloatArray, settings: RigidSettings) -> FloatArray:
    """Return what sensors read of speeds (F, J)."""
    return np.asarray(speed * np.array([p.speed_scale for p in settings.joints]))
