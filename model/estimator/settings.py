"""Noise, gates and limits of the estimator in SI units; found as ``docs/odometry_measured.md`` says."""

from dataclasses import asdict, dataclass
from math import isfinite
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw

Record: TypeAlias = NDArray[np.void]
RECORD_S = 0.01  # between two records of the forces


@dataclass(frozen=True, slots=True)
class EstimatorSettings:
    """What the estimator assumes about its own errors. "sd" is a standard deviation.

    Attributes:
        law: Friction law of the process.
        sway: Add the velocity of the body origin as the body tilts over its feet.
        sway_step_s: Time either way over which slopes are differenced [s].
        lag_s: Time constant with which the velocity follows the model [s]; 0 for none.
        bias_time_s: Memory of the velocity bias [s].
        bias_speed_sd: Of the bias along x and y while nothing slips [m/s].
        bias_speed_per_slip: What it grows by, over the root mean square of the feet's slip.
        bias_turn_sd: Of the bias of the yaw rate while nothing slips [rad/s].
        bias_turn_per_slip: What it grows by, over that slip [rad/m].
        foot_speed_sd: Of a foot's speed from encoder noise, white from tick to tick [m/s].
        speed_sd: Of the body's speed, white from tick to tick [m/s].
        turn_sd: Of its yaw rate, the same [rad/s].
        speed_per_slip: What the white part of the speed grows by, over the root mean square slip.
        turn_per_slip: What that of the yaw rate grows by, over that slip [rad/m].
        vibration_s: Time for which a force that shakes the body acts one way [s].
        vibration_per_slip: Of the yaw rate, where neither forces nor a gyro show it, over the root mean
            square slip [rad/m].
        side_share: Noise and bias of the speed along y over those along x, in which legs swing.
        bend: Bias that doubt about mu and K adds, over the velocity's standard deviation from that doubt:
            the model is no linear function of them.
        height_sd: Of a foot's height against the robot file, over the height of the body: lengths, zeros.
        com_sd: Of the centre of mass along x and y, over that height.
        slope_sd: Of the ground along x and y.
        parameter_sd: Of log mu and log K at the beginning.
        scale_sd: Of the log of the common friction at the beginning.
        parameter_walk: Random walk of log mu and log K while a foot tells of them [1/sqrt(s)].
        parameter_limit: Largest distance of log mu and log K from the robot file.
        gauge_sd: Of the sum of log mu, which is 0 by convention.
        force_period_s: Forces are used this often; more often they repeat their own errors [s].
        force_sd: Of a horizontal force over the weight, beside the share below.
        force_share_sd: Of a horizontal force over its own size.
        force_white_sd: Of a horizontal force over the weight from record to record: a transducer's noise.
        load_sd: Of a vertical force over the weight.
        creep_speed: Slip at which the regularised friction has 71 % of its size [m/s].
        rest_speed: Slip, root mean square of the loaded feet, at which predicted forces come by half from
            the viscous ansatz; more of them below [m/s]. 0 asks Coulomb's law alone.
        slip_speed: A foot faster than this over the ground tells of velocity and friction [m/s].
        clear_slip: Its slip must also be this many times as large as its own standard deviation: which
            way friction points is not known before.
        load_on: A foot counts as loaded above this share of the weight,
        load_off: and no longer below this one.
        adaptive: Learn the noise of each source, and how the body shakes, from what was measured. Health is
            judged in either case.
        learning_s: Memory of that [s].
        health_s: Memory of what health is judged by [s].
        least_scale: Smallest variance of a source's noise over that of these settings,
        most_scale: and its largest.
        least_weight: Smallest variance with which a source weighs in, over that of these settings: what is
            known of its errors is their size, not where they come from.
        delay_sd: Of the time for which forces are stamped [s].
        gate_load: Largest normalised innovation squared of a load, 1 degree of freedom.
        gate_pair: The same of a horizontal force, 2 degrees of freedom.
        gate_pose: The same of an absolute pose, 3 degrees of freedom.
        pose_limit: Distance of an absolute position from the estimate, beyond 5 sd of the difference, above
            which it is never used, however often it comes [m]. It may lie anywhere until a pose has been
            used, and again after the robot was carried or lost.
        reject_limit: Rejections in a row after which a foot is used again, with a larger sd.
        gyro_sd: Of a yaw gyro's reading [rad/s].
        gyro_bias_sd: Of its bias at the beginning [rad/s].
        gyro_bias_walk: Random walk of that bias [rad/s in 1/sqrt(s)].
        tilt_sd: Of a measured roll or pitch [rad].
        tilt_bias_sd: Of their offset at the beginning: how the IMU is mounted, and the slope [rad].
        tilt_bias_walk: Random walk of that offset, as the robot turns on a slope [rad/sqrt(s)].
        pose_sd: Of an absolute position [m].
        yaw_sd: Of an absolute yaw [rad].
        idle_speed: Feet slower than this in the body stand still [m/s].
        idle_time_s: After so long a standstill pose and parameters are held [s].
        idle_speed_sd: Of the velocity while held [m/s].
        steady_load: Largest change of a foot's share from one force record to the next while held.
        carried_speed_sd: Of the velocity while no foot carries the robot [m/s].
        carried_turn_sd: Of the yaw rate while no foot carries it [rad/s].
        carried_time_s: Memory of that motion [s].
        airborne_share: Feet together carrying less than this share of the weight: picked up.
        dead_leg_speed_sd: Added to the bias for each leg whose encoder is silent [m/s].
        dead_leg_turn_sd: The same for the yaw rate [rad/s].
        lost_after_s: Without an answer of the model for so long the estimate is lost [s].
        recover_s: Time that everything must be in order again for it to be ok [s].
        stale_force_s: Forces older than this are stale [s].
        longest_gap_s: A gap in time longer than this is bridged as if the robot were carried [s].
    """

    law: FrictionLaw = FrictionLaw.COULOMB
    sway: bool = True
    sway_step_s: float = 0.02
    lag_s: float = 0.005
    bias_time_s: float = 0.1
    bias_speed_sd: float = 0.0001
    bias_speed_per_slip: float = 0.08
    bias_turn_sd: float = 0.00005
    bias_turn_per_slip: float = 0.07
    foot_speed_sd: float = 0.001
    speed_sd: float = 0.0007
    turn_sd: float = 0.001
    speed_per_slip: float = 0.08
    turn_per_slip: float = 0.05
    vibration_s: float = 0.01
    vibration_per_slip: float = 0.4
    side_share: float = 0.5
    bend: float = 0.7
    height_sd: float = 0.014
    com_sd: float = 0.04
    slope_sd: float = 0.02
    parameter_sd: float = 0.25
    scale_sd: float = 0.25
    parameter_walk: float = 0.01
    parameter_limit: float = 1.0
    gauge_sd: float = 0.01
    force_period_s: float = 0.05
    force_sd: float = 0.01
    force_share_sd: float = 0.1
    force_white_sd: float = 0.0025
    load_sd: float = 0.02
    creep_speed: float = 0.001
    rest_speed: float = 0.006
    slip_speed: float = 0.004
    clear_slip: float = 3.0
    load_on: float = 0.06
    load_off: float = 0.03
    adaptive: bool = True
    learning_s: float = 10.0
    health_s: float = 4.0
    least_scale: float = 0.02
    most_scale: float = 25.0
    least_weight: float = 1.0
    delay_sd: float = 0.01
    gate_load: float = 10.8
    gate_pair: float = 13.8
    gate_pose: float = 16.3
    pose_limit: float = 1.0
    reject_limit: int = 10
    gyro_sd: float = 0.005
    gyro_bias_sd: float = 0.01
    gyro_bias_walk: float = 0.0001
    tilt_sd: float = 0.01
    tilt_bias_sd: float = 0.05
    tilt_bias_walk: float = 0.0005
    pose_sd: float = 0.002
    yaw_sd: float = 0.005
    idle_speed: float = 0.002
    idle_time_s: float = 0.3
    idle_speed_sd: float = 0.0001
    steady_load: float = 0.05
    carried_speed_sd: float = 0.3
    carried_turn_sd: float = 0.5
    carried_time_s: float = 0.5
    airborne_share: float = 0.3
    dead_leg_speed_sd: float = 0.05
    dead_leg_turn_sd: float = 0.2
    lost_after_s: float = 2.0
    recover_s: float = 1.0
    stale_force_s: float = 0.5
    longest_gap_s: float = 0.5

    def __post_init__(self) -> None:
        """Refuse values that no filter can work with."""
        for name in self.__slots__:
            value = getattr(self, name)
            if isinstance(value, FrictionLaw | bool):
                continue
            least = 0 if name in MAY_BE_ZERO else None
            if not isfinite(value) or (value < 0 if least == 0 else value <= 0):
                raise ModelError(
                    f"{name} of the estimator must be {'at least' if least == 0 else 'above'} 0, "
                    f"not {value}"
                )
        if self.load_off > self.load_on:
            raise ModelError("load_off of the estimator must not be above load_on")


def record_of(settings: EstimatorSettings, weight_n: float) -> Record:
    """The settings as compiled code takes them, (1,): each number under its name, and two more.

    ``weight_n`` is the weight carried [N], ``coulomb`` whether the law is Coulomb's, and ``sway_step_s`` is
    0 where sway is left out. A call takes a record in a tenth of the time of a named tuple.
    """
    values = asdict(settings) | {"weight_n": weight_n}
    coulomb = values.pop("law") is FrictionLaw.COULOMB
    values["sway_step_s"] *= values.pop("sway")
    kinds = [(name, np.float64) for name in values]
    return np.array([(*values.values(), coulomb)], dtype=[*kinds, ("coulomb", np.bool_)])


MAY_BE_ZERO = frozenset({
    "lag_s", "bias_speed_per_slip", "bias_turn_per_slip", "speed_per_slip", "turn_per_slip",
    "parameter_walk", "foot_speed_sd", "rest_speed", "bend", "height_sd", "com_sd", "slope_sd",
    "vibration_s", "vibration_per_slip", "force_white_sd", "delay_sd", "gyro_bias_walk", "tilt_bias_walk",
})  # fmt: skip
