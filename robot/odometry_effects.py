"""What the effects of a robot file add to the odometry: feet, weight, and the model's answers.

The estimator keeps its own model and its parameters. What the file's effects change in velocity and loads
is computed beside it, frame by frame, at the file's parameters, and added: to first order the same as an
estimator with the effects built in, and its derivatives and noise stay what they were.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import g as standard_gravity

from gap.frame import FrameAnswer, FrameModel
from gap.interfaces import Cause
from gap.legged_ground import weight_and_centre
from gap.legged_machine import LeggedMachine
from model.estimator_settings import EstimatorSettings
from model.estimator_types import AddedByEffects
from model.frames import FrictionLaw
from model.odometry import advance
from model.signals import Estimate, FloatArray, FootForces, FootMotion
from record.recording import Recording
from robot.config import RobotConfig
from robot.odometry_track import Progress

COULOMB = Cause("coulomb_friction", (), ())
# They change the feet that the estimator is given, not what its model makes of them.
OF_THE_FEET = frozenset({"shaft_zero_offset", "link_length", "leg_length", "encoder_scale"})


@dataclass(frozen=True, slots=True, eq=False)
class EffectFrames:
    """A recording of T ticks of N legs as a robot file with effects has it.

    Attributes:
        feet: (T, N, 3) each.
        weight_n: With what rides along.
        force_n: Forces without what sensors add, (T, N, 3).
        velocity_B: The file's model with its effects, (T, 3).
        force_B: Its forces, (T, N, 3).
        added: What the effects add at each tick of the span.
    """

    feet: FootMotion
    weight_n: float
    force_n: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_B: FloatArray  # noqa: N815
    added: tuple[AddedByEffects, ...]


def effect_frames(
    log: Recording,
    config: RobotConfig,
    settings: EstimatorSettings,
    span: tuple[int, int],
    progress: Progress | None,
) -> EffectFrames | None:
    """Run the file's model over the walking part of a recording; None for a file without effects.

    Args:
        log: The recording.
        config: The robot file.
        settings: Of the estimator; its law of friction.
        span: First tick, and the one after the last.
        progress: Told the share done.
    """
    if not config.effects:
        return None
    own, first, last = config.parameters, *span
    machine = LeggedMachine(own.body.mass, own.legs, own.linkage, own.contact, config.effects)
    plain, lawful = FrameModel(machine), FrameModel(_with_law(machine, settings.law))
    weight_n = weight_and_centre(machine, plain.settings.ground)[0]
    base = FrameModel(_as_the_estimator_has_it(machine, weight_n, settings.law))
    position, velocity = np.full((2, *log.force_n.shape), np.nan)
    twist, force = (
        np.full((last - first, 3), np.nan),
        np.full((last - first, *log.force_n.shape[1:]), np.nan),
    )
    true_n = log.force_n.copy()
    added: list[AddedByEffects] = []
    where = Estimate(int(log.t_s[first] * 1e9), np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
    for i in range(first, last):
        since_s = float(log.t_s[i] - log.t_s[0])
        reading = FootForces(0, log.force_n[i], np.isfinite(log.force_n[i]).all(axis=1))
        true_n[i] = plain.true_forces(reading, since_s).force_n
        now_ns = int(log.t_s[i] * 1e9)
        dt_s = (now_ns - where.t_ns) * 1e-9
        pose = np.array([*where.position_m, where.yaw_rad])
        answer = plain.solve(log.angle_rad[i], log.rate_rad_s[i], pose, where.velocity_B, dt_s)
        with_law, without = (
            one.solve(log.angle_rad[i], log.rate_rad_s[i], pose, where.velocity_B, dt_s)
            for one in (lawful, base)
        )
        where = advance(where, answer.contact.traction.velocity_B, now_ns)
        position[i], velocity[i] = answer.feet.position_m, answer.feet.velocity_m_s
        twist[i - first] = answer.contact.traction.velocity_B
        force[i - first] = answer.contact.traction.force_B
        added.append(_difference(with_law, without))
        if progress is not None and i % 200 == 0:
            progress((i - first) / (last - first))
    return EffectFrames(
        FootMotion(position, velocity), weight_n, true_n, twist, force, tuple(added)
    )


def _with_law(machine: LeggedMachine, law: FrictionLaw) -> LeggedMachine:
    """The estimator's own law of friction is no effect: it is on both sides of the difference."""
    if law is not FrictionLaw.COULOMB or COULOMB in machine.effects:
        return machine
    return replace(machine, effects=(*machine.effects, COULOMB))


def _as_the_estimator_has_it(
    machine: LeggedMachine, weight_n: float, law: FrictionLaw
) -> LeggedMachine:
    """The robot as the estimator's own model has it: its feet, its weight, and nothing else added."""
    kept = tuple(one for one in machine.effects if one.effect in OF_THE_FEET)
    bare = replace(machine, mass_kg=weight_n / standard_gravity, effects=kept)
    return _with_law(bare, law)


def _difference(with_effects: FrameAnswer, without: FrameAnswer) -> AddedByEffects:
    one, other = with_effects.contact, without.contact
    known = one.support.converged and other.support.converged
    if not (known and one.traction.valid and other.traction.valid):
        return AddedByEffects(np.zeros(3), np.zeros(len(one.support.load_n)))
    return AddedByEffects(
        one.traction.velocity_B - other.traction.velocity_B,
        one.support.load_n - other.support.load_n,
    )
