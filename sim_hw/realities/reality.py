"""A reality: how a virtual robot is built, part by part, where the usual twin is only one of many.

Parts are frozen values, so that any reality is made of others with ``dataclasses.replace``. A part's
default is that of the usual twin. What is drawn here (unequal legs) is drawn once for a reality and stays;
what differs from day to day is ``sim_hw.twin.days``.
"""

from dataclasses import dataclass, field, replace
from hashlib import sha256

import numpy as np

from model.values.arrays import FloatArray
from model.values.parameters import RobotParameters
from record.trial.header import TrialNoise
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.mujoco_model import PAD_MASS, ROW_MASS
from sim_hw.plant.parameters import (
    SIDE_DAMPING_RATIO,
    CrankLegs,
    DriveParameters,
    MotorParameters,
    PlantParameters,
)
from sim_hw.plant.structure import HARD_CONTACT, REGISTER_LOOP, ContactForm, ServoLoop
from sim_hw.twin.days import USUAL_DAYS, DayScatter, on_day
from sim_hw.twin.sensing import HEALTHY_NOISE, SensorParameters
from sim_hw.twin.twin import Twin


@dataclass(frozen=True, slots=True)
class Times:
    """A number of the robot file, or all of a list, times a factor."""

    factor: float


Numbers = float | tuple[float, ...] | tuple[tuple[float, ...], ...] | Times
RobotNumbers = tuple[tuple[str, Numbers], ...]


@dataclass(frozen=True, slots=True)
class Gears:
    """Gears of all servos.

    Attributes:
        backlash_rad: Play of every gear.
        compliance_rad_per_nm: Give of every gear.
        load: Dry friction for each N m that a gear carries; None is the motor's own.
        stribeck: Times the motor's own excess of friction at rest.
    """

    backlash_rad: float = 0.0
    compliance_rad_per_nm: float = 0.0
    load: float | None = None
    stribeck: float = 1.0


@dataclass(frozen=True, slots=True)
class Surface:
    """Ground and soles.

    Attributes:
        contact: How they touch.
        static_ratio: Friction at rest over that in motion, Stribeck's curve between them.
        static_speed_m_s: Speed at which the excess is down to 1/e.
        give_n_per_m: Stiffness of the ground under each foot; infinite is rigid.
        rolling_m: Radius of soles that roll; 0 is none.
    """

    contact: ContactForm = HARD_CONTACT
    static_ratio: float = 1.0
    static_speed_m_s: float = 0.01
    give_n_per_m: float = np.inf
    rolling_m: float = 0.0


@dataclass(frozen=True, slots=True)
class LegForm:
    """What legs are, besides their linkage.

    Attributes:
        foot_mass_kg: Mass that moves with each foot; 0 is next to none, as in the usual twin.
        side: Times the usual stiffness sideways.
        fore_aft: The same along x.
        side_damping_ratio: Share of critical damping of both on the foot's mass.
        hardening_per_m2: Vertical springs: times their stiffness, for each metre of travel squared.
        play_m: Free play of the vertical spring.
    """

    foot_mass_kg: float = 0.0
    side: float = 1.0
    fore_aft: float = 1.0
    side_damping_ratio: float = SIDE_DAMPING_RATIO
    hardening_per_m2: float = 0.0
    play_m: float = 0.0


@dataclass(frozen=True, slots=True)
class UnequalLegs:
    """One standard deviation of what differs from leg to leg and stays so, whatever the day.

    Attributes:
        stiffness: Relative.
        mu: Relative.
        length_m: Of each leg [m].
        link_m: Of each crank, coupler and rocker [m]; robots whose legs are cranks: of the crank.
        mount_m: Of each shaft's place along x and y [m].
    """

    stiffness: float = 0.0
    mu: float = 0.0
    length_m: float = 0.0
    link_m: float = 0.0
    mount_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Sensing:
    """What is measured.

    Attributes:
        noise: White noise of each sensor; NaN is a sensor that is not there.
        marker_share: Share of a leg's give that its marker goes along with: 1 on the foot.
        filter_s: Time constant of the force unit's own filter.
        wander_n: Coloured noise on each axis of force, one standard deviation.
        wander_s: Its correlation time.
        pose_delay_s: The cameras' poses come so much late.
    """

    noise: TrialNoise = HEALTHY_NOISE
    marker_share: float = 1.0
    filter_s: float = 0.0
    wander_n: float = 0.0
    wander_s: float = 1.0
    pose_delay_s: float = 0.0

    @property
    def forces(self) -> bool:
        """Whether there are transducers."""
        return bool(np.isfinite(self.noise.force_n))

    @property
    def markers(self) -> bool:
        """Whether there are markers on the legs."""
        return bool(np.isfinite(self.noise.foot_position_m))


@dataclass(frozen=True, slots=True)
class Reality:
    """How a virtual robot is built.

    Attributes:
        name: By which commands ask for it.
        differs: What differs from the usual twin, in one line.
        loop: The servos' control loop.
        gears: Their gears.
        surface: Ground and soles.
        leg: Legs besides their linkage.
        twist_rad_per_nm: Front of the chassis against its rear; 0 is rigid.
        unequal: What differs from leg to leg.
        days: What differs from day to day.
        sensing: What is measured.
        robot: Keys of the robot file (``body.mass``) with other numbers: another robot, whose file the lab
            has.
    """

    name: str
    differs: str
    loop: ServoLoop = REGISTER_LOOP
    gears: Gears = field(default_factory=Gears)
    surface: Surface = field(default_factory=Surface)
    leg: LegForm = field(default_factory=LegForm)
    twist_rad_per_nm: float = 0.0
    unequal: UnequalLegs = field(default_factory=UnequalLegs)
    days: DayScatter = USUAL_DAYS
    sensing: Sensing = field(default_factory=Sensing)
    robot: RobotNumbers = ()


def real_twin(reality: Reality, robot: RobotParameters, seed: int) -> Twin:
    """Return the healthy twin of a robot file in a reality, on the day that the seed stands for.

    Args:
        reality: How it is built.
        robot: Parameters of the robot file, the reality's own numbers in it.
        seed: Of the day and of the sensors' noise.
    """
    plant = _with_legs(reality, _with_surface(reality, PlantParameters.nominal(robot)))
    plant = replace(
        plant,
        drive=_drive(reality, plant.drive),
        motors=tuple(_motor(reality.gears, motor) for motor in plant.motors),
        twist=reality.twist_rad_per_nm,
    )
    sensing = reality.sensing
    sensors = replace(
        SensorParameters.healthy(robot.legs.count),
        noise=sensing.noise,
        marker_share=sensing.marker_share,
        force_filter_s=sensing.filter_s,
        force_wander_n=sensing.wander_n,
        force_wander_s=sensing.wander_s,
        pose_delay_s=sensing.pose_delay_s,
    )
    return on_day(Twin(robot.legs.names, plant, sensors, seed), reality.days)


def _drive(reality: Reality, drive: DriveParameters) -> DriveParameters:
    count, gears = len(drive.backlash), reality.gears
    return replace(
        drive,
        loop=reality.loop,
        backlash=np.full(count, gears.backlash_rad),
        compliance=np.full(count, gears.compliance_rad_per_nm),
    )


def _motor(gears: Gears, motor: MotorParameters) -> MotorParameters:
    load = motor.load if gears.load is None else gears.load
    return replace(
        motor,
        load=load,
        stribeck=gears.stribeck * motor.stribeck,
        load_stribeck=gears.stribeck * motor.load_stribeck,
    )


def _with_surface(reality: Reality, plant: PlantParameters) -> PlantParameters:
    surface = reality.surface
    round_legs = isinstance(plant.leg, CrankLegs) and plant.leg.radius.any()
    return replace(
        plant,
        contact=surface.contact,
        friction=replace(
            plant.friction,
            static_ratio=surface.static_ratio,
            static_speed=surface.static_speed_m_s,
        ),
        ground=replace(plant.ground, stiffness=np.full(plant.legs, surface.give_n_per_m)),
        rolling_radius=0.0 if round_legs else surface.rolling_m,
    )


def _with_legs(reality: Reality, plant: PlantParameters) -> PlantParameters:
    """Give the legs their form, and what differs between them: drawn by the reality's name."""
    form, unequal, count = reality.leg, reality.unequal, plant.legs
    random = np.random.default_rng(list(sha256(reality.name.encode()).digest()))
    stiffness = plant.stiffness * np.exp(unequal.stiffness * random.standard_normal(count))
    mu = plant.mu * np.exp(unequal.mu * random.standard_normal(count))
    length = unequal.length_m * random.standard_normal(count)
    mounts = plant.shaft_position.copy()
    mounts[:, :2] += unequal.mount_m * random.standard_normal((count, 2))
    links = unequal.link_m * random.standard_normal((3, count))
    foot_mass = form.foot_mass_kg or plant.foot_mass
    leg = plant.leg
    if isinstance(leg, CrankLegs):
        leg = replace(leg, length=leg.length + links[0])
    else:
        leg = replace(
            leg,
            crank=leg.crank + links[0],
            coupler=leg.coupler + links[1],
            rocker=leg.rocker + links[2],
        )
    return replace(
        plant,
        leg=leg,
        stiffness=stiffness,
        hardening=form.hardening_per_m2 * stiffness,
        mu=mu,
        leg_offset=plant.leg_offset + length,
        leg_play=np.full(count, form.play_m),
        shaft_position=mounts,
        side_stiffness=plant.side_stiffness * [form.fore_aft, form.side],
        side_damping_ratio=form.side_damping_ratio,
        foot_mass=foot_mass,
        inertia=plant.inertia + _inertia(plant, reality, foot_mass - plant.foot_mass),
    )


def _inertia(plant: PlantParameters, reality: Reality, more_kg: float) -> FloatArray:
    """What heavier feet and a divided chassis, unknown to the file, add to the robot's inertia, (3,)."""
    if np.isfinite(reality.surface.give_n_per_m):
        more_kg += PAD_MASS
    if reality.twist_rad_per_nm > 0:
        more_kg += ROW_MASS / 2
    x, z, _, _ = foot_path(plant, np.zeros(plant.legs))
    square = (plant.shaft_position + np.stack([x, np.zeros(plant.legs), z], axis=1)) ** 2
    about: FloatArray = more_kg * (square.sum(axis=1, keepdims=True) - square).sum(axis=0)
    return about
