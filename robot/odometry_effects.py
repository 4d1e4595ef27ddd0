"""What the effects of a robot file add to the odometry: feet, weight, and the model's answers.

The estimator keeps its own model and its parameters. What the file's effects change in velocity and loads
is computed beside it, frame by frame, at the file's parameters, and added: to first order the same as an
estimator with the effects built in, and its derivatives and noise stay what they were.
"""

from dataclasses import dataclass, replace

import numpy as np

from gap.frame import FrameAnswer, FrameModel
from gap.interfaces import Cause
from gap.legged_ground import weight_and_centre
from gap.legged_machine import LeggedMachine
from model.estimator_settings import EstimatorSettings
from model.estimator_types import AddedByEffects
from model.frames import FrictionLaw
from model.neighbourhood import neighbourhood
from model.odometry import advance
from model.params import ContactParameters
from model.signals import Estimate, FloatArray, FootForces, FootMotion
from record.recording import Recording
from robot.config import RobotConfig
from robot.odometry_track import Progress

COULOMB = Cause("coulomb_friction", (), ())


@dataclass(frozen=True, slots=True, eq=False)
class EffectMemory:
    """What is remembered from tick to tick.

    Attributes:
        began_ns: Time of the first tick: drifts count from there.
        where: Dead-reckoned pose, for effects that are bound to a place.
    """

    began_ns: int
    where: Estimate


@dataclass(frozen=True, slots=True, eq=False)
class EffectTick:
    """A tick as a robot file with effects has it.

    Attributes:
        answer: Feet, support and traction of the file's own model.
        forces: Without what sensors add.
        added: What the effects add to the estimator's model.
    """

    answer: FrameAnswer
    forces: FootForces
    added: AddedByEffects


class EffectsBeside:
    """What a robot file's effects add, tick by tick.

    Args:
        config: Robot file with effects.
        law: Law of friction of the estimator.
    """

    def __init__(self, config: RobotConfig, law: FrictionLaw) -> None:
        own = config.parameters
        machine = LeggedMachine(own.body.mass, own.legs, own.linkage, own.contact, config.effects)
        self._contact, self._law = own.contact, law
        self._plain = self._lawful = FrameModel(machine)
        if law is FrictionLaw.COULOMB and COULOMB not in machine.effects:
            # the estimator's own law is no effect: it is on both sides of the difference
            self._lawful = FrameModel(replace(machine, effects=(*machine.effects, COULOMB)))
        self.weight_n = weight_and_centre(machine, self._plain.settings.ground)[0]

    def prepare(self) -> None:
        """Load or make the machine code now."""
        self._plain.prepare()
        self._lawful.prepare()

    def step(
        self,
        memory: EffectMemory | None,
        t_ns: int,
        angle_rad: FloatArray,
        rate_rad_s: FloatArray,
        forces: FootForces,
    ) -> tuple[EffectMemory, EffectTick]:
        """Advance by a tick.

        Args:
            memory: What was, None before the first tick.
            t_ns: Time of the tick.
            angle_rad: Shafts, (N,).
            rate_rad_s: Their speeds, (N,).
            forces: As the calibrated sensors report them.
        """
        if memory is None:
            start = Estimate(t_ns, np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
            memory = EffectMemory(t_ns, start)
        where = memory.where
        dt_s = (t_ns - where.t_ns) * 1e-9
        pose = np.array([*where.position_m, where.yaw_rad])
        answer = self._plain.solve(angle_rad, rate_rad_s, pose, where.velocity_B, dt_s)
        beside = answer
        if self._lawful is not self._plain:
            beside = self._lawful.solve(angle_rad, rate_rad_s, pose, where.velocity_B, dt_s)
        truly = self._plain.true_forces(forces, (t_ns - memory.began_ns) * 1e-9)
        added = _difference(beside, self._contact, self.weight_n, self._law)
        where = advance(where, answer.contact.traction.velocity_B, t_ns)
        return EffectMemory(memory.began_ns, where), EffectTick(answer, truly, added)


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
    first, last = span
    beside = EffectsBeside(config, settings.law)
    position, velocity = np.full((2, *log.force_n.shape), np.nan)
    twist, force = (
        np.full((last - first, 3), np.nan),
        np.full((last - first, *log.force_n.shape[1:]), np.nan),
    )
    true_n = log.force_n.copy()
    added: list[AddedByEffects] = []
    start = Estimate(int(log.t_s[first] * 1e9), np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
    memory = EffectMemory(int(log.t_s[0] * 1e9), start)
    for i in range(first, last):
        reading = FootForces(0, log.force_n[i], np.isfinite(log.force_n[i]).all(axis=1))
        memory, tick = beside.step(
            memory, int(log.t_s[i] * 1e9), log.angle_rad[i], log.rate_rad_s[i], reading
        )
        feet, traction = tick.answer.feet, tick.answer.contact.traction
        true_n[i] = tick.forces.force_n
        position[i], velocity[i] = feet.position_m, feet.velocity_m_s
        twist[i - first], force[i - first] = traction.velocity_B, traction.force_B
        added.append(tick.added)
        if progress is not None and i % 200 == 0:
            progress((i - first) / (last - first))
    return EffectFrames(
        FootMotion(position, velocity), beside.weight_n, true_n, twist, force, tuple(added)
    )


def _difference(
    answer: FrameAnswer, contact: ContactParameters, weight_n: float, law: FrictionLaw
) -> AddedByEffects:
    feet, found = answer.feet, answer.contact
    nothing = AddedByEffects(np.zeros(3), np.zeros(len(contact.mu)))
    if not (np.isfinite(feet.position_m).all() and np.isfinite(feet.velocity_m_s).all()):
        return nothing
    base = neighbourhood(feet, contact, weight_n, law, 0.0)
    if base.reason != 0 or not (found.support.converged and found.traction.valid):
        return nothing
    return AddedByEffects(
        found.traction.velocity_B - base.velocity_B, found.support.load_n - base.load_n
    )
