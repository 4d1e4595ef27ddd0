"""What the software assumes about the robot: frozen parameters, one dataclass per table.

They are read from the robot file by ``robot.config.robot_file`` and passed down; nothing here has a
default, so a value that the file does not give cannot sneak in. N is the number of legs.
"""

from dataclasses import dataclass
from typing import TypeAlias

from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.machine_names import MachineNames


@dataclass(frozen=True, slots=True, eq=False)
class BodyParameters:
    """Rigid body. Mass in kg; inertia about the centre of mass, (3,) [kg m^2]."""

    mass: float
    inertia: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class LegParameters:
    """Names and places of the legs.

    Attributes:
        names: Leg names, N of them, in the order used everywhere.
        shaft_position: Crank shaft in the body frame, (N, 3) [m].
    """

    names: tuple[str, ...]
    shaft_position: FloatArray

    @property
    def count(self) -> int:
        """Number of legs N."""
        return len(self.names)


@dataclass(frozen=True, slots=True, eq=False)
class FourBarParameters:
    """One four-bar for all legs, in the leg's x-z plane.

    Attributes:
        crank: Crank length [m].
        ground_pivot: Rocker pivot relative to the crank shaft, (2,) (x, z) [m].
        coupler: Crank pin A to rocker pin B [m].
        rocker: Rocker length [m].
        foot: Foot in the coupler frame, (2,): along A->B, and to its left [m].
        branch: +1 if B lies to the left of the line from A to the ground pivot, -1 if to the right.
        mid_stance: Crank direction at shaft angle 0, from +x towards +z [rad];
            crank direction = mid_stance - shaft angle.
    """

    crank: float
    ground_pivot: FloatArray
    coupler: float
    rocker: float
    foot: FloatArray
    branch: int
    mid_stance: float


@dataclass(frozen=True, slots=True)
class CrankParameters:
    """One leg on its servo's shaft for all legs, in the leg's x-z plane; straight down at shaft angle 0.

    Attributes:
        length: Shaft to toe [m].
        radius: Of the half circle that rolls, from the toe towards the shaft [m]; at most half the length,
            0 for a leg that stands on its toe.
    """

    length: float
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class ChainParameters:
    """Legs of any number of joints as drawn, every joint at its drawn value; J joints, body axes.

    A joint at ``angle`` has turned by ``zero + sign * angle`` from where it is drawn; one that slides has
    moved by that along its axis.

    Attributes:
        joints: Names, J of them, in the order used everywhere.
        parent: Row of the joint that carries each, always a smaller one; -1 for the body, (J,).
        slides: Whether each slides along its axis instead of turning about it, (J,).
        axis: Unit vectors, (J, 3).
        place: A point of each axis, (J, 3) [m].
        sign: 1 or -1, (J,).
        zero: Drawn joint to joint at 0, (J,) [rad], [m] where it slides.
        foot_joint: Row of the joint that carries each foot, (N,).
        foot: Middles of the feet, (N, 3) [m].
        radius: Of feet that are balls, (N,) [m]: they touch the ground so far below their middle, in body
            axes, and roll; 0 of points.
    """

    joints: tuple[str, ...]
    parent: IntArray
    slides: BoolArray
    axis: FloatArray
    place: FloatArray
    sign: FloatArray
    zero: FloatArray
    foot_joint: IntArray
    foot: FloatArray
    radius: FloatArray

    @property
    def count(self) -> int:
        """Number of joints J."""
        return len(self.joints)

    def joints_of(self, leg: int) -> tuple[int, ...]:
        """Return the rows of the joints between the body and a leg's foot, from the body on."""
        rows, joint = [], int(self.foot_joint[leg])
        while joint >= 0:
            rows.append(joint)
            joint = int(self.parent[joint])
        return tuple(reversed(rows))


# What a leg can be: the type says which kind.
LegGeometry = FourBarParameters | CrankParameters | ChainParameters


def names_of(legs: LegParameters, leg: LegGeometry) -> MachineNames:
    """Return the names of a robot's joints and legs."""
    joints = leg.joints if isinstance(leg, ChainParameters) else legs.names
    return MachineNames(joints, legs.names)


@dataclass(frozen=True, slots=True, eq=False)
class ContactParameters:
    """Vertical leg springs and friction.

    Attributes:
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: w of the paper's eqn:anisotropic, (N, 2).
    """

    stiffness: FloatArray
    mu: FloatArray
    anisotropy: FloatArray


@dataclass(frozen=True, slots=True)
class ServoParameters:
    """What the legs' servos can do at the supply voltage.

    Attributes:
        supply_voltage: [V].
        rated_torque_limit: Soft limit at the shaft [N m].
        max_speed: Largest shaft speed a gait may ask for [rad/s].
        max_acceleration: Largest shaft acceleration a gait may ask for [rad/s^2].
        models: Name of each leg's servo, N of them.
    """

    supply_voltage: float
    rated_torque_limit: float
    max_speed: float
    max_acceleration: float
    models: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class BuehlerParameters:
    """A gait whose legs turn at one speed in stance and at another in the return, rounded where they meet.

    Attributes:
        name: Name of its table in the robot file.
        frequency: [Hz].
        touchdown: Phase at which the stance of each leg begins, (N,) [cycles].
        stance_sweep: Shaft angle swept in stance, centred on ``offset``, (N,) [rad].
        duty: Stance share of the period, (N,).
        offset: Shaft angle at mid-stance, (N,) [rad].
        blend: Share of the period over which each change of speed is spread.
    """

    name: str
    frequency: float
    touchdown: FloatArray
    stance_sweep: FloatArray
    duty: FloatArray
    offset: FloatArray
    blend: float


@dataclass(frozen=True, slots=True, eq=False)
class CubicParameters:
    """A gait whose shaft angles are cubics of time, one in stance and one in the return.

    Attributes:
        name: Name of its table in the robot file.
        frequency: [Hz].
        touchdown: Phase at which the stance of each leg begins, (N,) [cycles].
        stance_sweep: Shaft angle swept in stance, centred on ``offset``, (N,) [rad].
        duty: Stance share of the period, (N,).
        offset: Shaft angle at mid-stance, (N,) [rad].
        cubic: 0 is constant speed in stance; towards 1 the shaft nearly stops at mid-stance, (N,).
    """

    name: str
    frequency: float
    touchdown: FloatArray
    stance_sweep: FloatArray
    duty: FloatArray
    offset: FloatArray
    cubic: FloatArray


@dataclass(frozen=True, slots=True)
class PluginParameters:
    """A gait that a Python file gives; ``gaits.plugin`` builds it.

    Attributes:
        name: Name of the gait, that of the file.
        file: The file, as it was named.
        text: What is in it.
    """

    name: str
    file: str
    text: str


ClockParameters: TypeAlias = BuehlerParameters | CubicParameters
GaitParameters: TypeAlias = ClockParameters | PluginParameters


@dataclass(frozen=True, slots=True, eq=False)
class RobotParameters:
    """Everything the model and the gaits need to know about one robot.

    Its gaits are in the order of the robot file; one of a Python file comes after them.
    """

    body: BodyParameters
    legs: LegParameters
    leg: LegGeometry
    contact: ContactParameters
    servo: ServoParameters
    gaits: tuple[GaitParameters, ...]

    @property
    def names(self) -> MachineNames:
        """Names of joints and legs."""
        return names_of(self.legs, self.leg)
