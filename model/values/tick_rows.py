"""What was sensed in many ticks, as arrays: a row a tick."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.legs import FootForces, JointState
from model.values.readings import ImuRecord, PoseRecord
from model.values.tick import SensedTick


@dataclass(frozen=True, slots=True, eq=False)
class JointRows:
    """``JointState`` of T ticks: times are (T,), all else (T, J)."""

    t_ns: IntArray
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    current_a: FloatArray
    duty: FloatArray
    voltage_v: FloatArray
    temperature_c: FloatArray
    valid: BoolArray

    def state(self, k: int) -> JointState:
        """Return that of tick k."""
        return JointState(
            int(self.t_ns[k]), self.angle_rad[k], self.rate_rad_s[k], self.current_a[k], self.duty[k],
            self.voltage_v[k], self.temperature_c[k], self.valid[k],
        )  # fmt: skip

    @staticmethod
    def stacked(states: Sequence[JointState]) -> "JointRows":
        """Return states of one robot as rows."""
        rows = [
            (s.angle_rad, s.rate_rad_s, s.current_a, s.duty, s.voltage_v, s.temperature_c)
            for s in states
        ]
        angle, rate, current, duty, voltage, temperature = (
            readonly(np.array(column)) for column in zip(*rows, strict=True)
        )
        t_ns, valid = np.array([s.t_ns for s in states]), np.array([s.valid for s in states])
        return JointRows(
            readonly(t_ns), angle, rate, current, duty, voltage, temperature, readonly(valid)
        )


@dataclass(frozen=True, slots=True, eq=False)
class ForceRows:
    """``FootForces`` of T ticks: times (T,), forces (T, N, 3), whether they are known (T, N)."""

    t_ns: IntArray
    force_n: FloatArray
    valid: BoolArray

    def forces(self, k: int) -> FootForces:
        """Return those of tick k."""
        return FootForces(int(self.t_ns[k]), self.force_n[k], self.valid[k])

    @staticmethod
    def stacked(forces: Sequence[FootForces]) -> "ForceRows":
        """Return the forces on one robot as rows."""
        t_ns, force_n = np.array([f.t_ns for f in forces]), np.array([f.force_n for f in forces])
        valid = np.array([f.valid for f in forces])
        return ForceRows(readonly(t_ns), readonly(force_n), readonly(valid))


@dataclass(frozen=True, slots=True, eq=False)
class SensedRows:
    """``SensedTick`` of T ticks of one robot.

    Attributes:
        t_ns: Times of the ticks, (T,).
        joints: Calibrated shafts.
        forces: Latest measured foot forces.
        poses: Absolute poses received since the tick before, of each.
        imu: Readings of an inertial unit received since then, of each.
    """

    t_ns: IntArray
    joints: JointRows
    forces: ForceRows
    poses: Sequence[tuple[PoseRecord, ...]]
    imu: Sequence[tuple[ImuRecord, ...]]

    def __len__(self) -> int:
        return len(self.t_ns)

    def __iter__(self) -> Iterator[SensedTick]:
        return map(self.tick, range(len(self)))

    @property
    def sizes(self) -> tuple[int, int]:
        """N legs and J joints."""
        return self.forces.force_n.shape[1], self.joints.angle_rad.shape[1]

    def tick(self, k: int) -> SensedTick:
        """Return tick k."""
        return SensedTick(
            int(self.t_ns[k]),
            self.joints.state(k),
            self.forces.forces(k),
            self.poses[k],
            self.imu[k],
        )

    @staticmethod
    def stacked(ticks: Sequence[SensedTick]) -> "SensedRows":
        """Return ticks of one robot, at least one, as rows."""
        return SensedRows(
            readonly(np.array([tick.t_ns for tick in ticks])),
            JointRows.stacked([tick.joints for tick in ticks]),
            ForceRows.stacked([tick.forces for tick in ticks]),
            [tick.poses for tick in ticks],
            [tick.imu for tick in ticks],
        )
