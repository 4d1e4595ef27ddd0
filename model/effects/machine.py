"""A legged robot as its robot file describes it: what the chain knows of it, effects included."""

from dataclasses import dataclass

import numpy as np
from scipy.constants import g as standard_gravity

from model.effects.causes import Cause
from model.effects.written import causes_for
from model.errors import ConfigError, GapError
from model.kinematics.legs import reach_m
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
    def length_m(self) -> float:
        """From the middle of the machine to the farthest place along x where a foot may stand."""
        shaft = float(np.abs(self.legs.shaft_position[:, 0]).max())
        return shaft + reach_m(self.leg)

    @property
    def names(self) -> MachineNames:
        """Names of joints and legs."""
        return names_of(self.legs, self.leg)

    @property
    def weight_n(self) -> float:
        """Weight."""
        return self.mass_kg * standard_gravity


def parse_machine(text: str) -> LeggedMachine:
    """Read the physical tables of a robot file; all others (wiring, loop, gaits) may be absent.

    Raises:
        GapError: A table is missing or wrong.
    """
    try:
        top = parse_table(text)
        leg = read_leg(top)
        legs = read_legs(top.table("legs"), leg)
        return LeggedMachine(
            mass_kg=read_body(top.table("body")).mass,
            legs=legs,
            leg=leg,
            contact=read_contact(top.table("contact"), legs.count),
            effects=causes_for(top, legs, leg),
        )
    except ConfigError as error:
        raise GapError(f"the robot file cannot be used: {error}") from error
