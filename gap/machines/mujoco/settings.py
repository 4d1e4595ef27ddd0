"""What causes come to in the numbers of a machine: of each joint, each body, the world and the clocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from gap.machines.mujoco.drive import JointNumbers
from gap.machines.mujoco.effect_table import BODY, WORLD, MjcfEffect
from model.effects.causes import Cause, joint_by_joint


class BodyNumbers(NamedTuple):
    """How a body differs from the file: mass with inertia, centre of mass, and a mass near its end."""

    mass_ratio: float = 1.0
    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    payload_kg: float = 0.0
    payload_x_m: float = 0.0
    payload_y_m: float = 0.0
    payload_z_m: float = 0.0


class WorldNumbers(NamedTuple):
    """Gravity turned about x and then y, friction of contacts, and when readings are stamped."""

    roll_rad: float = 0.0
    pitch_rad: float = 0.0
    contact_friction: float = 1.0
    stamp_delay_s: float = 0.0
    clock_ratio: float = 1.0


N = TypeVar("N", JointNumbers, BodyNumbers, WorldNumbers)


@dataclass(frozen=True, slots=True)
class RigidSettings:
    """All numbers of a machine; equal settings give equal predictions."""

    joints: tuple[JointNumbers, ...]
    bodies: tuple[BodyNumbers, ...]
    world: WorldNumbers


def nominal_settings(joints: Sequence[JointNumbers], bodies: int) -> RigidSettings:
    """Return the numbers of a machine as its file and its drive say."""
    return RigidSettings(tuple(joints), (BodyNumbers(),) * bodies, WorldNumbers())


def with_causes(
    nominal: RigidSettings,
    causes: Sequence[Cause],
    effects: Mapping[str, MjcfEffect],
    joints: Sequence[str],
    bodies: Sequence[str],
) -> RigidSettings:
    """Return settings with causes of the catalogue in them; those of no joint are of all."""
    own, carried, world = list(nominal.joints), list(nominal.bodies), nominal.world
    for whole in causes:
        for cause in joint_by_joint(whole, effects[whole.effect]):
            effect = effects[cause.effect]
            pairs = tuple(zip(effect.places, cause.values, strict=True))
            if effect.acts_on == WORLD:
                world = moved(world, pairs)
            elif effect.acts_on == BODY:
                for at in _touched(cause, bodies):
                    carried[at] = moved(carried[at], pairs)
            else:
                for at in _touched(cause, joints):
                    own[at] = moved(own[at], pairs)
    return RigidSettings(tuple(own), tuple(carried), world)


def _touched(cause: Cause, names: Sequence[str]) -> list[int]:
    """Numbers of the joints or bodies that a cause touches: all, if it names none."""
    return [at for at, name in enumerate(names) if not cause.joints or name in cause.joints]


def moved(numbers: N, pairs: Sequence[tuple[tuple[str, str], float]]) -> N:
    """Return numbers with values added (+), multiplied (*), as a limit (<) or in their place (=)."""
    for (place, how), value in pairs:
        old: float = getattr(numbers, place)
        new = {"+": old + value, "*": old * value, "<": min(old, value), "=": value}[how]
        numbers = numbers._replace(**{place: new})
    return numbers
