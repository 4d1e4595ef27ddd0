"""A gait of a robot in figures: speed, margin, slip, torque, clearance, each with its limit."""

import math
from dataclasses import dataclass

import numpy as np

from gaits.gait import Gait
from gaits.limits import gait_peaks
from model.support.static_margin import static_margin
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import RobotParameters, names_of
from robot.design.cycle import GaitCycle, most_torque, swing_share, walk_cycle
from robot.design.motors import duty_of, motor_line
from robot.design.shift import BestShift, best_shift

STEERING = (0.0, -1.0, 1.0)
# Of a swing: before and after it a foot may still or already stand; in between it has to be in the air.
MID_SWING = (0.2, 0.8)
AMPLE_MARGIN = 0.1  # of the width or length of all foot paths


@dataclass(frozen=True, slots=True, eq=False)
class GaitFigures:
    """One gait at its frequency, walking straight where nothing else is said.

    Attributes:
        gait: Its name.
        frequency_hz: Cycles a second.
        speed_m_s: Mean forward speed under Coulomb's law; NaN where the robot tips over.
        turn_rad_s: Mean yaw rate at full steering to the left.
        feet_least: Fewest feet in stance.
        feet_most: Most.
        margin_m: Least static margin of the feet in stance, at any steering.
        margin_phase: Phase where it is least.
        margin_B: From the centre of mass to the nearest edge there, (2,) [m].
        span_m: Width or length of all foot paths, the smaller.
        centred: How the margin would be with all shafts moved; not looked for where it is large as it is.
        falls: Share of the cycle in which the centre of mass is over no feet at all.
        unsolved: Share of the cycle for which the model has no answer though it should.
        tilt_rad: How far the body tilts to and fro over a cycle.
        height_m: Mean height of the body frame over the ground.
        sink_m: Most that a leg spring is pressed.
        lift_m: Least height that a swinging foot reaches, of all legs.
        lift_leg: The leg with that.
        load_share: Largest share of the weight on one foot.
        dragged_share: Largest share of the weight on feet in the middle of their swing.
        dragged_leg: The leg with most of it.
        idle_share: Largest share of its stance in which a leg carries nothing.
        idle_leg: The leg with that.
        forced_slip_m_s: Root mean square slip of standing feet that no motion of the body takes away.
        slip_m_s: Mean slip of feet under Coulomb's law, by load.
        shaft_rad_s: Largest shaft speed at any steering.
        shaft_rad_s2: Largest shaft acceleration at any steering.
        torque_rms_nm: Of the shaft with the largest one.
        torque_peak_nm: Largest torque at any steering under Coulomb's law.
        torque_most_nm: Largest torque with friction at its limit, whatever its direction.
        torque_joint: The joint with that.
        duty_most: Largest share of the supply voltage that a servo needs, by its data sheet.
        stall_share: Largest root mean square torque over the servo's stall torque.
    """

    gait: str
    frequency_hz: float
    speed_m_s: float
    turn_rad_s: float
    feet_least: int
    feet_most: int
    margin_m: float
    margin_phase: float
    margin_B: FloatArray  # noqa: N815 - frame suffix
    span_m: float
    centred: BestShift
    falls: float
    unsolved: float
    tilt_rad: float
    height_m: float
    sink_m: float
    lift_m: float
    lift_leg: str
    load_share: float
    dragged_share: float
    dragged_leg: str
    idle_share: float
    idle_leg: str
    forced_slip_m_s: float
    slip_m_s: float
    shaft_rad_s: float
    shaft_rad_s2: float
    torque_rms_nm: float
    torque_peak_nm: float
    torque_most_nm: float
    torque_joint: str
    duty_most: float
    stall_share: float

    @property
    def slip_share(self) -> float:
        """Slip of the feet over the body's speed; infinite where it does not get on."""
        speed = abs(self.speed_m_s)
        if speed > 0:
            return self.slip_m_s / speed
        return math.inf if self.slip_m_s > 0 else 0.0

    @property
    def turn_radius_m(self) -> float:
        """Of the circle at full steering; infinite where it does not turn."""
        return abs(self.speed_m_s / self.turn_rad_s) if self.turn_rad_s else math.inf


@dataclass(frozen=True, slots=True, eq=False)
class WalkedGait:
    """A gait's figures, and the cycle straight ahead that most of them are of."""

    figures: GaitFigures
    cycle: GaitCycle


def walk_gait(robot: RobotParameters, gait: Gait, frequency_hz: float | None = None) -> WalkedGait:
    """Walk a gait straight and at full steering both ways.

    Args:
        robot: The robot.
        gait: One of its gaits.
        frequency_hz: Cycles a second; the gait's own if None.
    """
    cycles = [walk_cycle(robot, gait, steer, frequency_hz) for steer in STEERING]
    straight, names = cycles[0], robot.legs.names
    joints = names_of(robot.legs, robot.leg).joints
    slope, curvature = gait_peaks(gait)
    worst = min(cycles, key=lambda one: one.margin.margin_m.min())
    at = int(worst.margin.margin_m.argmin())
    answer = straight.answer
    weight = robot.body.mass * STANDARD_GRAVITY
    torque = np.abs([one.torque_nm for one in cycles])
    most = np.array([most_torque(one, robot.contact.mu) for one in cycles])
    lift = _lift(straight)
    dragged = _dragged(cycles) / weight
    idle = _idle(straight)
    feet, servos = straight.stance.sum(axis=1), robot.servo.models
    everywhere = np.ones_like(straight.stance)
    beside = static_margin(straight.feet.position_m[..., :2], everywhere).margin_m < 0
    figures = GaitFigures(
        gait=gait.name,
        frequency_hz=straight.frequency_hz,
        speed_m_s=_mean(answer.velocity_B[:, 0]),
        turn_rad_s=_mean(cycles[-1].answer.velocity_B[:, 2]),
        feet_least=int(feet.min()),
        feet_most=int(feet.max()),
        margin_m=float(worst.margin.margin_m[at]),
        margin_phase=float(worst.phase[at]),
        margin_B=worst.margin.nearest_m[at],
        span_m=float(np.ptp(straight.feet.position_m[..., :2], axis=(0, 1)).min()),
        centred=_centred(cycles, float(worst.margin.margin_m[at])),
        falls=float(beside.mean()),
        unsolved=float(np.mean(~np.isfinite(answer.pose[:, 0]) & ~beside)),
        tilt_rad=float(np.hypot(*np.ptp(answer.pose[:, :2], axis=0))),
        height_m=_mean(answer.pose[:, 2]),
        sink_m=float(np.max(-straight.height_m, initial=0.0)),
        lift_m=float(lift.min()),
        lift_leg=names[int(lift.argmin())],
        load_share=_most(answer.load_n) / weight,
        dragged_share=float(dragged.sum(axis=1).max()),
        dragged_leg=names[int(dragged.max(axis=0).argmax())],
        idle_share=float(idle.max()),
        idle_leg=names[int(idle.argmax())],
        forced_slip_m_s=_rms(straight.forced.rms_m_s),
        slip_m_s=_mean_slip(straight),
        shaft_rad_s=slope * straight.frequency_hz,
        shaft_rad_s2=curvature * straight.frequency_hz**2,
        torque_rms_nm=_most(_rms_of_legs(torque[0])),
        torque_peak_nm=_most(torque),
        torque_most_nm=_most(most),
        torque_joint=joints[int(np.nan_to_num(most).max(axis=(0, 1)).argmax())],
        duty_most=_most(np.array([_duty(robot, one) for one in cycles])) if servos else math.nan,
        stall_share=_most(_rms_of_legs(torque[0]) / motor_line(robot.servo).stall_nm)
        if servos
        else math.nan,
    )
    return WalkedGait(figures, straight)


def _centred(cycles: list[GaitCycle], margin_m: float) -> BestShift:
    """Return what moving the shafts would bring, where the margin is small beside the robot's size."""
    feet = np.concatenate([cycle.feet.position_m[..., :2] for cycle in cycles])
    if margin_m > AMPLE_MARGIN * float(np.ptp(feet, axis=(0, 1)).min()):
        return BestShift(np.zeros(2), margin_m)
    return best_shift(feet, np.concatenate([cycle.stance for cycle in cycles]))


def _known(values: FloatArray) -> FloatArray:
    known: FloatArray = values[np.isfinite(values)]
    return known


def _mean(values: FloatArray) -> float:
    known = _known(values)
    return float(known.mean()) if len(known) == len(values) else math.nan


def _most(values: FloatArray) -> float:
    known = _known(values)
    return float(known.max()) if len(known) else math.nan


def _rms(values: FloatArray) -> float:
    known = _known(values)
    return float(np.sqrt((known**2).mean())) if len(known) else math.nan


def _rms_of_legs(torque_nm: FloatArray) -> FloatArray:
    rms: FloatArray = np.sqrt((torque_nm**2).mean(axis=0))
    return rms


def _duty(robot: RobotParameters, cycle: GaitCycle) -> FloatArray:
    return duty_of(robot.servo, cycle.torque_nm, cycle.shafts.slope * cycle.frequency_hz)


def _lift(cycle: GaitCycle) -> FloatArray:
    """Height that each foot reaches in its swing, (N,) [m]; infinite for one that never swings."""
    height = np.where(cycle.stance | np.isnan(cycle.height_m), -np.inf, cycle.height_m)
    lift: FloatArray = np.where(cycle.stance.all(axis=0), np.inf, height.max(axis=0))
    return lift


def _dragged(cycles: list[GaitCycle]) -> FloatArray:
    """Load on each foot in the middle of its swing, of all cycles one behind the other, (., N) [N]."""
    loads = []
    for cycle in cycles:
        share = swing_share(cycle.stance)
        middle = (share > MID_SWING[0]) & (share < MID_SWING[1])
        loads.append(np.where(middle, np.nan_to_num(cycle.answer.load_n), 0.0))
    return np.concatenate(loads)


def _idle(cycle: GaitCycle) -> FloatArray:
    """Share of its stance in which each foot carries nothing, (N,)."""
    stands = np.isfinite(cycle.answer.load_n) & cycle.stance
    idle = (stands & (cycle.answer.load_n <= 0)).sum(axis=0)
    share: FloatArray = idle / np.maximum(stands.sum(axis=0), 1)
    return share


def _mean_slip(cycle: GaitCycle) -> float:
    """Slip of feet on the ground, weighted by their load [m/s]."""
    load = np.nan_to_num(cycle.answer.load_n)
    speed = np.nan_to_num(np.hypot(cycle.answer.slip_B[..., 0], cycle.answer.slip_B[..., 1]))
    total = float(load.sum())
    return float((load * speed).sum()) / total if total > 0 else math.nan
