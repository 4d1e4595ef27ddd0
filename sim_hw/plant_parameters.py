"""What the plant is made of: its own parameters, apart from what the model believes.

``nominal`` copies the geometry of a robot file, so that a virtual robot exists for every robot file.
Everything else is the plant's own: each value says where it comes from, or that it is assumed.
"""

from dataclasses import dataclass

import numpy as np

from model.params import RobotParameters
from model.signals import FloatArray


@dataclass(frozen=True, slots=True)
class MotorParameters:
    """A geared MX-106 seen at its output. Values: Rhoban/bam, model m4 for the MX-106.

    The friction budget at speed w under motor torque tm and external torque te is
    ``viscous |w| + exp(-|w / stribeck_speed|^stribeck_power) (stribeck + load_stribeck |tm - te|) +
    load |tm - te|``.

    Attributes:
        torque_constant: [N m/A].
        resistance: [ohm].
        armature: Rotor inertia seen at the output [kg m^2].
        duty_limit: Largest duty the output stage reaches.
        stribeck: Static friction above the kinetic one [N m].
        load: Friction per torque carried.
        load_stribeck: The same, at rest only.
        stribeck_speed: [rad/s].
        stribeck_power: Shape of the decay.
        viscous: [N m s].
        thermal_resistance: Motor to air [K/W]; assumed, the data sheet gives none.
        thermal_time: Thermal time constant [s]; assumed.
    """

    torque_constant: float = 2.231
    resistance: float = 2.372
    armature: float = 0.02457
    duty_limit: float = 0.9625
    stribeck: float = 0.1049
    load: float = 0.0092
    load_stribeck: float = 0.2224
    stribeck_speed: float = 1.623
    stribeck_power: float = 1.323
    viscous: float = 0.0510
    thermal_resistance: float = 2.5
    thermal_time: float = 300.0


@dataclass(frozen=True, slots=True, eq=False)
class PlantParameters:
    """The whole plant. N legs.

    Attributes:
        mass: Whole robot [kg].
        inertia: Whole robot about its centre of mass, legs in mid-stance, (3,) [kg m^2].
        shaft_position: Crank shafts, body frame, (N, 3) [m].
        crank: [m].
        ground_pivot: (2,) [m].
        coupler: [m].
        rocker: [m].
        foot: (2,) [m].
        branch: +1 or -1.
        mid_stance: [rad].
        stiffness: Vertical leg springs, (N,) [N/m].
        damping: Vertical leg dampers, (N,) [N s/m]; assumed, 5 % of critical on a third of the mass.
        mu: Coulomb friction of each foot, (N,).
        foot_mass: Mass that moves with each foot, below the spring [kg]; assumed.
        carriage_mass: Mass that moves with each linkage, above the spring [kg]; assumed.
        foot_radius: [m]; assumed.
        motor: The servos' motors.
        battery_v: Open-circuit voltage [V].
        battery_resistance: Battery and cable [ohm]; assumed.
        ambient_c: [degC]; assumed.
        clearance: Body underside below the origin [m]; assumed.
        time_step_s: Step of motors, firmware and linkage.
        substeps: MuJoCo steps in each of them.
        gravity: [m/s^2].
    """

    mass: float
    inertia: FloatArray
    shaft_position: FloatArray
    crank: float
    ground_pivot: FloatArray
    coupler: float
    rocker: float
    foot: FloatArray
    branch: int
    mid_stance: float
    stiffness: FloatArray
    damping: FloatArray
    mu: FloatArray
    foot_mass: float
    carriage_mass: float
    foot_radius: float
    motor: MotorParameters
    battery_v: float
    battery_resistance: float
    ambient_c: float
    clearance: float
    time_step_s: float
    substeps: int
    gravity: float

    @staticmethod
    def nominal(robot: RobotParameters) -> "PlantParameters":
        """Return a plant with the geometry, springs and friction of a robot file."""
        legs = robot.legs.count
        stiffness = robot.contact.stiffness.copy()
        damping = 0.1 * np.sqrt(stiffness * robot.body.mass / 3)
        link = robot.linkage
        return PlantParameters(
            mass=robot.body.mass,
            inertia=robot.body.inertia.copy(),
            shaft_position=robot.legs.shaft_position.copy(),
            crank=link.crank,
            ground_pivot=link.ground_pivot.copy(),
            coupler=link.coupler,
            rocker=link.rocker,
            foot=link.foot.copy(),
            branch=link.branch,
            mid_stance=link.mid_stance,
            stiffness=stiffness,
            damping=damping,
            mu=robot.contact.mu.copy(),
            foot_mass=min(0.03, 0.03 * robot.body.mass / legs),
            carriage_mass=min(0.03, 0.03 * robot.body.mass / legs),
            foot_radius=0.005,
            motor=MotorParameters(),
            battery_v=robot.servo.supply_voltage,
            battery_resistance=0.05,
            ambient_c=25.0,
            clearance=0.03,
            time_step_s=0.001,
            substeps=2,
            gravity=9.80665,
        )

    @property
    def legs(self) -> int:
        """Number of legs N."""
        return len(self.shaft_position)
