"""A robot file's effects in the tick: the model with them, and what they add to the estimator's own.

The estimator keeps its own model and its parameters. What the file's effects change in velocity and loads
is computed separately, frame by frame, at the file's parameters, and added: to first order the same as an
estimator with the effects built in, and its derivatives and noise stay what they were.
"""

from dataclasses import dataclass, replace

import numpy as np

from model.effects.causes import Cause
from model.effects.frame import FrameAnswer, FrameModel
from model.effects.machine import LeggedMachine
from model.effects.pushes import weight_and_centre
from model.motion.dead_reckoning import advance
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.estimate import AddedByEffects
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootForces
from model.values.tick import DeadReckoning
from robot.config.robot_file import RobotConfig

COULOMB = Cause("coulomb_friction", (), ())
# They change the feet that the estimator is given, not what its model makes of them.
OF_THE_FEET = frozenset(
    {"shaft_zero_offset", "link_length", "hip_mount_offset", "leg_length", "encoder_scale"}
)


def machine_of(config: RobotConfig) -> LeggedMachine:
    """Return the robot of a robot file, effects included, as the diagnosis knows it."""
    own = config.parameters
    return LeggedMachine(own.body.mass, own.legs, own.leg, own.contact, config.effects)


def model_of(config: RobotConfig) -> FrameModel | None:
    """Return the frame-by-frame model of a robot file's effects; None for a file without."""
    if not config.effects:
        return None
    model = FrameModel(machine_of(config))
    model.prepare()
    return model


@dataclass(frozen=True, slots=True, eq=False)
class EffectMemory:
    """What is remembered from tick to tick.

    Attributes:
        began_ns: Time of the first tick: drifts count from there.
        where: Dead-reckoned pose, for effects that are bound to a place.
    """

    began_ns: int
    where: DeadReckoning


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
        machine = machine_of(config)
        self._plain = FrameModel(machine)
        self.weight_n = weight_and_centre(machine, self._plain.settings)[0]
        with_law = _with_law(machine, law)
        bare = _as_the_estimator_has_it(machine, self.weight_n, law)
        self._nothing = AddedByEffects(np.zeros(3), np.zeros(machine.legs.count))
        self._beside: tuple[FrameModel, FrameModel] | None = None
        if with_law.effects != bare.effects:
            own_law = with_law.effects == machine.effects
            self._beside = (self._plain if own_law else FrameModel(with_law)), FrameModel(bare)

    def prepare(self) -> None:
        """Load or make the machine code now."""
        for model in (self._plain, *(self._beside or ())):
            model.prepare()

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
            start = DeadReckoning(t_ns, np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
            memory = EffectMemory(t_ns, start)
        where = memory.where
        dt_s = (t_ns - where.t_ns) * 1e-9
        pose = np.array([*where.position_m, where.yaw_rad])
        answer = self._plain.solve(angle_rad, rate_rad_s, pose, where.velocity_B, dt_s)
        true_forces = self._plain.true_forces(forces, (t_ns - memory.began_ns) * 1e-9)
        added = self._nothing
        if self._beside is not None:
            with_effects, without = (
                answer
                if model is self._plain
                else model.solve(angle_rad, rate_rad_s, pose, where.velocity_B, dt_s)
                for model in self._beside
            )
            added = _difference(with_effects, without)
        where = advance(where, answer.contact.traction.velocity_B, t_ns)
        return EffectMemory(memory.began_ns, where), EffectTick(answer, true_forces, added)


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
    bare = replace(machine, mass_kg=weight_n / STANDARD_GRAVITY, effects=kept)
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
