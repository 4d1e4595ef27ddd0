"""What is added to the legged simulator: one number for everything that an effect can change.

Neutral values are the simulator as it stands. All fields are numbers or tuples, so that settings
compare and hash by value and stages can be remembered by them.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

Numbers = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ShaftSettings:
    """Actuation and kinematics; tuples have one entry a leg."""

    delay_s: float
    lags_s: tuple[Numbers, ...]  # low passes one behind the other, each with one entry a leg
    speed_limit_rad_s: Numbers
    compliance_rad_nm: Numbers
    backlash_rad: Numbers
    zero_offset_rad: Numbers
    crank_m: Numbers
    coupler_m: Numbers
    rocker_m: Numbers
    hip_x_m: Numbers
    hip_y_m: Numbers
    rolling_m: float


@dataclass(frozen=True, slots=True)
class GroundSettings:
    """Support, friction, dynamics and external forces."""

    stiffness_ratio: Numbers
    ground_stiffness: float
    leg_length_m: Numbers
    slope_x: float
    slope_y: float
    step_height_m: float
    step_x_m: float
    com_x_m: float
    com_y_m: float
    payloads: tuple[Numbers, ...]  # mass, x, y of each
    twist_rad_nm: float
    mu_ratio: Numbers
    w_x: Numbers
    w_y: Numbers
    coulomb: bool
    static_ratio: float
    static_speed_m_s: float
    patch_ratio: float
    patch_x_m: float
    tilt_coupling: bool
    flex_lateral_m_n: float
    flex_longitudinal_m_n: float
    inertia_s: float
    tether_x_n: float
    tether_y_n: float
    drag_n_s_m: float

    @property
    def resists_motion(self) -> bool:
        """Whether drag or inertia acts."""
        return bool(self.drag_n_s_m or self.inertia_s)


@dataclass(frozen=True, slots=True)
class SensorSettings:
    """What sensors and clocks make of the truth."""

    force_gain: Numbers
    bias_x_n: Numbers
    bias_y_n: Numbers
    bias_z_n: Numbers
    drift_n_s: Numbers
    force_yaw_rad: Numbers
    force_delay_s: float
    force_lag_s: float
    pose_delay_s: float
    pose_yaw_rad: float
    pose_x_m: float
    pose_y_m: float
    clock_ratio: float
    encoder_ratio: Numbers


@dataclass(frozen=True, slots=True, eq=False)
class Added:
    """A user's effect in use: called with the signals of its stage, its values and its legs.

    Attributes:
        stage: Where it acts.
        act: ``act(signals, values, legs) -> signals``; see ``gap.effect_file``.
        values: In the order of its parameters.
        legs: Which legs, (N,) of True and False.
    """

    stage: str
    act: Callable[..., Any]
    values: Numbers
    legs: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that is added."""

    shaft: ShaftSettings
    ground: GroundSettings
    sensor: SensorSettings
    added: tuple[Added, ...] = field(default=())

    def at(self, stage: str) -> tuple[Added, ...]:
        """Return the users' effects of a stage."""
        return tuple(added for added in self.added if added.stage == stage)


NO_LIMIT_RAD_S = 10.0  # twice what the servos can do: no limit


def neutral_settings(legs: int) -> Settings:
    """Return the simulator as it stands."""
    zero, one = (0.0,) * legs, (1.0,) * legs
    return Settings(
        ShaftSettings(
            delay_s=0.0,
            lags_s=(),
            speed_limit_rad_s=(NO_LIMIT_RAD_S,) * legs,
            compliance_rad_nm=zero,
            backlash_rad=zero,
            zero_offset_rad=zero,
            crank_m=zero,
            coupler_m=zero,
            rocker_m=zero,
            hip_x_m=zero,
            hip_y_m=zero,
            rolling_m=0.0,
        ),
        GroundSettings(
            stiffness_ratio=one,
            ground_stiffness=1.0,
            leg_length_m=zero,
            slope_x=0.0,
            slope_y=0.0,
            step_height_m=0.0,
            step_x_m=0.0,
            com_x_m=0.0,
            com_y_m=0.0,
            payloads=(),
            twist_rad_nm=0.0,
            mu_ratio=one,
            w_x=zero,
            w_y=zero,
            coulomb=False,
            static_ratio=1.0,
            static_speed_m_s=0.005,
            patch_ratio=1.0,
            patch_x_m=0.0,
            tilt_coupling=False,
            flex_lateral_m_n=0.0,
            flex_longitudinal_m_n=0.0,
            inertia_s=0.0,
            tether_x_n=0.0,
            tether_y_n=0.0,
            drag_n_s_m=0.0,
        ),
        SensorSettings(
            force_gain=one,
            bias_x_n=zero,
            bias_y_n=zero,
            bias_z_n=zero,
            drift_n_s=zero,
            force_yaw_rad=zero,
            force_delay_s=0.0,
            force_lag_s=0.0,
            pose_delay_s=0.0,
            pose_yaw_rad=0.0,
            pose_x_m=0.0,
            pose_y_m=0.0,
            clock_ratio=1.0,
            encoder_ratio=one,
        ),
    )
