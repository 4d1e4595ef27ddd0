"""A legged robot as its robot file describes it: what the chain knows of it, effects included."""

from dataclasses import dataclass

from model.effects.causes import Cause
from model.effects.machine_scale import RobotSize, size_of
from model.effects.written import causes_for
from model.errors import ConfigError, GapError
from model.parameters.tables import (
    parse_table,
    read_body,
    read_contact,
    read_leg,
    read_legs,
)
from model.values.machine_names import MachineNames
from model.values.parameters import ContactParameters, LegGeometry, LegParameters, names_of


@dataclass(frozen=True, slots=True, eq=False)
class LeggedMachine:
    """A robot whose legs are on springs.

    Attributes:
        mass_kg: Whole robot.
        legs: Names and crank shafts; the body frame's origin is at the centre of mass.
        leg: Geometry of one leg, the same for all.
        contact: Leg springs and friction.
        effects: What the robot file adds to the nominal model.
    """

    mass_kg: float
    legs: LegParameters
    leg: LegGeometry
    contact: ContactParameters
    effects: tuple[Cause, ...] = ()

    @property
    def size(self) -> RobotSize:
        """Weight and reach."""
        return size_of(self.mass_kg, self.legs, self.leg)

    @property
    def names(self) -> MachineNames:
        """Names of joints and legs."""
        return names_of(self.legs, self.leg)


def parse_machine(text: str) -> LeggedMachine:
    """Read the physical tables of a robot file; all others (wiring, loop, gaits) may be absent.

    Raises:
        GapError: A table is missing or wrong.
    """
    try:
        top = parse_table(text)
        leg = read_leg(top)
        legs = read_legs(top.table("legs"), leg)
        mass_kg = read_body(top.table("body")).mass
        return LeggedMachine(
            mass_kg=mass_kg,
            legs=legs,
            leg=leg,
            contact=read_contact(top.table("contact"), legs.count),
            effects=causes_for(top, mass_kg, legs, leg),
        )
    except ConfigError as error:
        raise GapError(f"the robot file cannot be used: {error}") from error
