"""How plants differ in construction, not only in numbers: servo loop, contact. Today's is the default.

Called by the plant, the servos' firmware and ``sim_hw.realities``, which composes robots of them.
"""

from dataclasses import dataclass
from enum import StrEnum


class GearSide(StrEnum):
    """On which side of the gear an angle is measured."""

    MOTOR = "motor"
    SHAFT = "shaft"


class LoopKind(StrEnum):
    """What a servo's control loop is."""

    POSITION = "position"  # the registers' PID on the angle, as the MX-106's manual has it
    CASCADED = "cascaded"  # P on the angle asks for a speed, PI on the speed gives the duty


@dataclass(frozen=True, slots=True)
class ServoLoop:
    """The control loop of all servos.

    Attributes:
        kind: What it is.
        gain: Of ``POSITION``: times the P gain of the registers.
        speed_damping: Of ``POSITION``: duty for each rad/s of the shaft, against it.
        angle_gain: Of ``CASCADED``: speed asked for, for each rad of error [1/s].
        speed_gain: Of ``CASCADED``: duty for each rad/s of missing speed.
        speed_integral: Of ``CASCADED``: duty for each rad of missing speed, integrated.
        profile_speed: The servo's own profile moves its set point no faster [rad/s]; 0 is no profile.
        profile_acceleration: Nor does it change that speed faster [rad/s^2]; 0 does not limit it.
        feedback: Where the loop has its angle from; play outside of it is not held.
        encoder: Where the reported angle is measured.
    """

    kind: LoopKind = LoopKind.POSITION
    gain: float = 1.0
    speed_damping: float = 0.0
    angle_gain: float = 25.0
    speed_gain: float = 0.5
    speed_integral: float = 4.0
    profile_speed: float = 0.0
    profile_acceleration: float = 0.0
    feedback: GearSide = GearSide.MOTOR
    encoder: GearSide = GearSide.SHAFT


REGISTER_LOOP = ServoLoop()
"""The loop of the registers on the motor's side of the gear, without a profile of its own."""


@dataclass(frozen=True, slots=True)
class ContactForm:
    """How MuJoCo makes the contact of feet and ground.

    Attributes:
        elliptic: The friction cone; if not, a pyramid with edges along the contact's axes.
        time_constant_s: In which a penetration is pushed out; 0 is the least that MuJoCo allows.
        damping_ratio: Of that; below 1 a foot bounces.
        solimp: MuJoCo's impedance of the contact: how little it gives.
        friction_ratio: Impedance of friction over that of the normal (``impratio``): a sticking foot creeps
            the less the larger it is; near 1 friction is regularised, a steep line through zero speed.
    """

    elliptic: bool = True
    time_constant_s: float = 0.0
    damping_ratio: float = 1.0
    solimp: tuple[float, float, float, float, float] = (0.95, 0.99, 0.001, 0.5, 2.0)
    friction_ratio: float = 100.0


HARD_CONTACT = ContactForm()
"""As hard as the step allows, with an elliptic cone, sticking well."""
