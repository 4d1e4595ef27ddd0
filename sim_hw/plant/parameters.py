"""What the plant is made of: its own parameters, apart from what the model assumes.

``nominal`` copies the geometry of a robot file, so that a virtual robot exists for every robot file.
Everything else is the plant's own: each value says where it comes from, or that it is assumed. What a
healthy robot does not have (play, a step in the ground, a tether) has a default that switches it off.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from drivers.dynamixel.catalog import MODEL_BY_NAME, MX_106
from drivers.dynamixel.servo_model import MotorRatings
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import (
    ChainParameters,
    CrankParameters,
    FourBarParameters,
    LegGeometry,
    RobotParameters,
)
from sim_hw.plant.structure import HARD_CONTACT, REGISTER_LOOP, ContactForm, ServoLoop

CLEARANCE_M = 0.03
# Side springs are damped to this share of critical on the foot's mass; assumed.
SIDE_DAMPING_RATIO = 0.5
SIDE_SHARE = 12.0  # stiffness of a leg sideways over that of its vertical spring; assumed
TIME_STEP_S, SUBSTEPS = 0.001, 2  # of firmware and records; of physics in each
STEP_S = TIME_STEP_S / SUBSTEPS
# Natural frequency of a foot on its leg, times the step; beyond 1.1 a standing robot trembles.
FOLLOWED = 1.0


@dataclass(frozen=True, slots=True)
class MotorParameters:
    """A geared motor seen at its output. Values: Rhoban/bam, model m4 for the MX-106; others by ``of``.

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
        battery_v: Open-circuit voltage [V].
        battery_resistance: Battery and cable [ohm]; assumed.
        ambient_c: [degC]; assumed.
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
    battery_v: float = 12.0
    battery_resistance: float = 0.05
    ambient_c: float = 25.0

    @staticmethod
    def of(ratings: MotorRatings, battery_v: float) -> "MotorParameters":
        """Return another servo's motor: what was identified of the MX-106, scaled by both data sheets.

        Stall torque and no-load speed keep the MX-106's ratio to the data sheet. Assumed to be as with it:
        mechanical time constant, shape of the friction, how warm it gets at stall. The current at stall is
        then 0.8 to 1.7 times the data sheet's.

        Args:
            ratings: Of the servo.
            battery_v: Open-circuit voltage [V].
        """
        base, one = MotorParameters(), MX_106.ratings
        volts = ratings.voltage_v / one.voltage_v
        speed = ratings.no_load_rpm / one.no_load_rpm
        torque = ratings.stall_torque_n_m / one.stall_torque_n_m
        constant = volts / speed
        resistance = constant * volts / torque
        return replace(
            base,
            torque_constant=base.torque_constant * constant,
            resistance=base.resistance * resistance,
            armature=base.armature * (constant**2 / resistance),
            stribeck=base.stribeck * torque,
            stribeck_speed=base.stribeck_speed * speed,
            viscous=base.viscous * (torque / speed),
            thermal_resistance=base.thermal_resistance * (resistance / volts**2),
            battery_v=battery_v,
        )


@dataclass(frozen=True, slots=True, eq=False)
class DriveParameters:
    """Between the command and the crank, (N,) each.

    Attributes:
        delay_s: A goal acts so much later; one for all servos.
        lag_s: Time constant of the firmware's set point behind the goal; 0 is none.
        speed_limit: Fastest that the set point moves [rad/s].
        compliance: Twist between motor and shaft [rad/N m].
        backlash: Full play between motor and shaft [rad].
        friction_rad: Error at which the servo's loop overcomes the shaft's own dry friction [rad].
        crank_offset: Crank minus encoder [rad].
        hold_rate: Events a second in which a servo misses its goals for a while [1/s].
        hold_s: How long it misses them.
        loop: The servos' control loop.
    """

    delay_s: float
    lag_s: FloatArray
    speed_limit: FloatArray
    compliance: FloatArray
    backlash: FloatArray
    friction_rad: FloatArray
    crank_offset: FloatArray
    hold_rate: FloatArray
    hold_s: float = 0.3
    loop: ServoLoop = REGISTER_LOOP

    @staticmethod
    def ideal(legs: int) -> "DriveParameters":
        """Return a drive with none of all that."""
        none = np.zeros(legs)
        return DriveParameters(0.0, none, np.full(legs, np.inf), none, none, none, none, none)


@dataclass(frozen=True, slots=True, eq=False)
class FrictionParameters:
    """What makes friction more than Coulomb's with one coefficient a foot.

    Attributes:
        anisotropy: w of mu (1 + w w^T), body axes, (N, 2).
        static_ratio: Coefficient at rest over the sliding one.
        static_speed: Sliding speed at which the excess is down to 1/e [m/s].
        patch_ratio: Coefficient beyond ``patch_x`` over that before it.
        patch_x: World x at which it changes [m].
        fade_s: Time constant with which each foot's coefficient fades, (N,) [s].
        fade_floor: Share of it that stays.
        adhesion: Force with which a foot clings to the ground while it is within a millimetre, (N,) [N].
    """

    anisotropy: FloatArray
    fade_s: FloatArray
    adhesion: FloatArray
    static_ratio: float = 1.0
    static_speed: float = 0.01
    patch_ratio: float = 1.0
    patch_x: float = np.inf
    fade_floor: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class GroundParameters:
    """Shape and give of the ground.

    Attributes:
        slope: Rise per metre along world x and y, (2,).
        step_height: Height of a step up [m]; 0 is none.
        step_x: World x where it begins [m].
        stiffness: Under each foot [N/m]; infinite is rigid, (N,).
    """

    slope: FloatArray
    stiffness: FloatArray
    step_height: float = 0.0
    step_x: float = np.inf


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What pulls at the body from outside.

    Attributes:
        pull_x: Constant force along world x [N].
        pull_y: Along world y.
        drag: Force against the body's speed over the ground [N s/m].
        gust: Standard deviation of a wandering horizontal force [N].
        gust_time: Its correlation time [s].
    """

    pull_x: float = 0.0
    pull_y: float = 0.0
    drag: float = 0.0
    gust: float = 0.0
    gust_time: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class FourBarLegs:
    """Legs that are four-bars, as in the robot file.

    Attributes:
        crank: (N,) [m].
        ground_pivot: (2,) [m].
        coupler: (N,) [m].
        rocker: (N,) [m].
        foot: (2,) [m].
        branch: +1 or -1.
        mid_stance: [rad].
    """

    crank: FloatArray
    ground_pivot: FloatArray
    coupler: FloatArray
    rocker: FloatArray
    foot: FloatArray
    branch: int
    mid_stance: float


@dataclass(frozen=True, slots=True, eq=False)
class CrankLegs:
    """Legs that are cranks: shaft to toe, and the half circle that rolls, (N,) each [m]."""

    length: FloatArray
    radius: FloatArray


PlantLegs = FourBarLegs | CrankLegs


def plant_legs(leg: LegGeometry, count: int) -> PlantLegs:
    """Return ``count`` legs as a robot file has one."""
    match leg:
        case FourBarParameters():
            return FourBarLegs(
                crank=np.full(count, leg.crank),
                ground_pivot=leg.ground_pivot.copy(),
                coupler=np.full(count, leg.coupler),
                rocker=np.full(count, leg.rocker),
                foot=leg.foot.copy(),
                branch=leg.branch,
                mid_stance=leg.mid_stance,
            )
        case CrankParameters():
            return CrankLegs(np.full(count, leg.length), np.full(count, leg.radius))
        case ChainParameters():
            raise ConfigError(
                "leg.kind", "there is no virtual robot whose legs have several joints"
            )


def _clearance(leg: LegGeometry) -> float:
    """Underside of the body below its origin [m]: no lower than a quarter of a short crank."""
    return min(CLEARANCE_M, leg.length / 4) if isinstance(leg, CrankParameters) else CLEARANCE_M


@dataclass(frozen=True, slots=True, eq=False)
class PlantParameters:
    """The whole plant. N legs.

    Attributes:
        mass: Whole robot without payload [kg].
        inertia: Whole robot about its centre of mass, legs in mid-stance, (3,) [kg m^2].
        shaft_position: Crank shafts, body frame, (N, 3) [m].
        leg: Dimensions of the legs, of whatever kind.
        stiffness: Vertical leg springs, (N,) [N/m].
        damping: Vertical leg dampers, (N,) [N s/m]; assumed, 5 % of critical on a third of the mass.
        side_stiffness: Leg along body x and y, (N, 2) [N/m]; assumed.
        side_damping_ratio: Share of critical damping of these springs on the foot's mass.
        hardening: Vertical leg springs get stiffer with the cube of their travel, (N,) [N/m^3]; 0 is none.
        leg_offset: Leg longer than the linkage says, (N,) [m].
        leg_play: Free play of the leg's vertical spring, (N,) [m].
        mu: Coulomb friction of each foot, (N,).
        foot_mass: Mass that moves with each foot, below the springs [kg]; assumed.
        foot_radius: Of the ball that touches the ground; it does not turn [m]; assumed.
        rolling_radius: Of feet that do turn with their link [m]; 0 is none. Round legs have their own.
        com: Centre of mass in the body frame, (2,) [m].
        payload: Further mass [kg].
        payload_position: Of the payload in the body frame, (2,) [m].
        twist: Front against rear of the chassis about x [rad/N m].
        ballast_s: A weightless mass towed by the body, so large that the friction of all feet takes this
            time to bring it to a slip of 20 mm/s; 0 is none.
        motors: Each leg's motor, N of them; their battery is one.
        drive: Between command and crank.
        friction: Of the feet.
        ground: Under the feet.
        disturbance: What pulls at the body.
        contact: How feet and ground touch.
        clearance: Body underside below the origin [m]; assumed.
        time_step_s: Step of firmware and records.
        substeps: MuJoCo steps in each of them.
        servo_substeps: Steps of motor and linkage in each MuJoCo step.
        gravity: [m/s^2].
    """

    mass: float
    inertia: FloatArray
    shaft_position: FloatArray
    leg: PlantLegs
    stiffness: FloatArray
    damping: FloatArray
    side_stiffness: FloatArray
    hardening: FloatArray
    leg_offset: FloatArray
    leg_play: FloatArray
    mu: FloatArray
    drive: DriveParameters
    friction: FrictionParameters
    ground: GroundParameters
    motors: tuple[MotorParameters, ...]
    foot_mass: float
    foot_radius: float = 0.005
    side_damping_ratio: float = SIDE_DAMPING_RATIO
    rolling_radius: float = 0.0
    com: FloatArray = field(default_factory=lambda: np.zeros(2))
    payload: float = 0.0
    payload_position: FloatArray = field(default_factory=lambda: np.zeros(2))
    twist: float = 0.0
    ballast_s: float = 0.0
    disturbance: Disturbance = field(default_factory=Disturbance)
    contact: ContactForm = HARD_CONTACT
    clearance: float = CLEARANCE_M
    time_step_s: float = TIME_STEP_S
    substeps: int = SUBSTEPS
    servo_substeps: int = 2
    gravity: float = 9.80665

    @staticmethod
    def nominal(robot: RobotParameters) -> "PlantParameters":
        """Return a plant with the geometry, springs and friction of a robot file.

        Raises:
            ConfigError: A leg's spring is so stiff that the steps of physics cannot follow it.
        """
        legs = robot.legs.count
        stiffness = robot.contact.stiffness.copy()
        foot_mass = min(0.05, 0.04 * robot.body.mass / legs)
        most = foot_mass * (FOLLOWED / STEP_S) ** 2
        if stiffness.max() > most:
            raise ConfigError(
                "contact.stiffness",
                f"{stiffness.max():g} N/m is more than the virtual robot can follow in steps of "
                f"{1e3 * STEP_S:g} ms; give at most {most:.2g} N/m (legs give by millimetres)",
            )
        return PlantParameters(
            mass=robot.body.mass,
            inertia=robot.body.inertia.copy(),
            shaft_position=robot.legs.shaft_position.copy(),
            leg=plant_legs(robot.leg, legs),
            stiffness=stiffness,
            damping=0.1 * np.sqrt(stiffness * robot.body.mass / 3),
            side_stiffness=np.tile(np.minimum(SIDE_SHARE * stiffness, most)[:, None], 2),
            hardening=np.zeros(legs),
            leg_offset=np.zeros(legs),
            leg_play=np.zeros(legs),
            mu=robot.contact.mu.copy(),
            drive=DriveParameters.ideal(legs),
            friction=FrictionParameters(
                anisotropy=robot.contact.anisotropy.copy(),
                fade_s=np.full(legs, np.inf),
                adhesion=np.zeros(legs),
            ),
            ground=GroundParameters(np.zeros(2), np.full(legs, np.inf)),
            foot_mass=foot_mass,
            motors=tuple(
                MotorParameters.of(MODEL_BY_NAME[name].ratings, robot.servo.supply_voltage)
                for name in robot.servo.models
            ),
            clearance=_clearance(robot.leg),
        )

    @property
    def turning_radius(self) -> FloatArray:
        """Radius of what turns at each leg's end and rolls, (N,) [m]; 0 is none."""
        if isinstance(self.leg, CrankLegs) and self.leg.radius.any():
            return self.leg.radius
        return np.full(self.legs, self.rolling_radius)

    @property
    def legs(self) -> int:
        """Number of legs N."""
        return len(self.shaft_position)
