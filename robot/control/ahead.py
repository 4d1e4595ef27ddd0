"""Senses and model of many recorded ticks at once: what depends on inputs alone, computed beforehand.

A loop cannot know the next ticks, a replay does. Calibration, feet and the model's answer depend on no
decision, as long as no servo is down. They are the same numbers, to the bit, that the step computes; the
step takes them instead, tick after tick, while the shafts are those that were assumed.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drivers.ati.foot_forces import ForceScales
from drivers.dynamixel.joints import joint_states
from drivers.dynamixel.settings import ServoBusSettings
from gaits.plan import Goals
from model.kinematics.one_shaft import OneShaftKinematics
from model.motion.differentiate import latest_rates
from model.quasistatic.frame import solve_frames_in_order
from model.values.arrays import FloatArray, IntArray
from model.values.contact import ContactSolution
from model.values.legs import FootForces, FootMotion, JointState
from model.values.parameters import ContactParameters
from model.values.tick import Inputs
from robot.control.state import Senses


class Ahead(NamedTuple):
    """What is known of a tick beforehand.

    Attributes:
        after: Shafts of the tick before, for which all of this holds.
        joints: Shafts.
        forces: Forces of the newest record; None where there is none.
        times_ns: Of ``Senses``.
        angles_rad: Of ``Senses``.
        feet: Unloaded feet, with speeds from the latest angles.
        servo_feet: The same with the servos' own speeds; None where nobody wants them.
        contact: The model's answer.
        goals: What the plan before the block wants; None if that is not known.
    """

    after: JointState
    joints: JointState
    forces: FootForces | None
    times_ns: IntArray
    angles_rad: FloatArray
    feet: FootMotion
    servo_feet: FootMotion | None
    contact: ContactSolution
    goals: Goals | None


class LookAhead:
    """Computes it for a robot that a controller drives.

    Args:
        kinematics: Joints to feet.
        contact: Leg springs and friction.
        weight_n: The robot's weight [N].
        bus: How servos are mounted.
        scales: Calibration of the forces.
        servo_feet: Whether feet are wanted with the servos' own speeds, too.
    """

    def __init__(
        self,
        kinematics: OneShaftKinematics,
        contact: ContactParameters,
        weight_n: float,
        bus: ServoBusSettings,
        scales: ForceScales,
        *,
        servo_feet: bool,
    ) -> None:
        self._kinematics = kinematics
        self._contact = contact
        self._weight_n = weight_n
        self._bus = bus
        self._scales = scales
        self._servo_feet = servo_feet

    def of(
        self, before: Senses, first_ns: int | None, inputs: Sequence[Inputs], goals: Sequence[Goals]
    ) -> list[Ahead]:
        """Compute what is known of ticks in a row, from the next one on.

        Args:
            before: Senses of the tick before the first of them.
            first_ns: Its own time instead of that of the read, for the first tick of a run [ns].
            inputs: Of the ticks.
            goals: What the plan wants in them; none if that is not known.

        Returns:
            Of so many ticks, from the first, as nothing is unusual in.
        """
        count, legs = 0, before.angles_rad.shape[1]
        for one in inputs:
            if one.servos is None or one.servo_events or len(one.servos.valid) != legs:
                break
            count += 1
        if not count or before.down.any():
            return []
        inputs = inputs[:count]
        joints = joint_states([one.servos for one in inputs if one.servos is not None], self._bus)
        times = [*before.times_ns[1:].tolist(), *(one.t_ns for one in joints)]
        window = len(before.times_ns)
        if first_ns is not None:
            times[window - 1] = first_ns
        times_ns = np.array(times, dtype=np.int64)
        angles_rad = np.vstack([before.angles_rad[1:], *(one.angle_rad for one in joints)])
        rates = latest_rates(times_ns, angles_rad, window)
        feet = self._kinematics.feet(angles_rad[window - 1 :], rates)
        contacts = solve_frames_in_order(feet, self._contact, self._weight_n)
        own: list[FootMotion | None] = [None] * count
        if self._servo_feet:
            rates_rad_s = np.array([one.rate_rad_s for one in joints])
            both = self._kinematics.feet(angles_rad[window - 1 :], rates_rad_s)
            own = list(map(FootMotion, both.position_m, both.velocity_m_s))
        forces = self._scales.of_newest([one.forces for one in inputs])
        shafts = [before.joints, *joints]
        return [
            Ahead(
                shafts[k], shafts[k + 1], forces[k], times_ns[k : k + window],
                angles_rad[k : k + window],
                FootMotion(feet.position_m[k], feet.velocity_m_s[k]),
                own[k], contacts[k],
                goals[k] if goals else None,
            )
            for k in range(count)
        ]  # fmt: skip
