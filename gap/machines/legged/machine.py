"""The legged robot under diagnosis: what its simulator believes about it."""

from dataclasses import dataclass

import numpy as np
from scipy.constants import g as standard_gravity

from gap.interfaces import Cause
from gap.machines.legged.robot_effects import causes_of
from model.errors import ConfigError, GapError
from model.parameters.effects import read_effects
from model.parameters.robot import ContactParameters, LegParameters, LinkageParameters
from model.parameters.tables import (
    parse_table,
    read_body,
    read_contact,
    read_legs,
    read_linkage,
)
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True, eq=False)
class LeggedMachine:
    """A robot whose legs are four-bars on springs.

    Attributes:
        mass_kg: Whole robot.
        legs: Names and crank shafts; the body frame's origin is at the centre of mass.
        linkage: One four-bar for all legs.
        contact: Leg springs and friction.
        effects: What the robot file adds to the nominal model.
    """

    mass_kg: float
    legs: LegParameters
    linkage: LinkageParameters
    contact: ContactParameters
    effects: tuple[Cause, ...] = ()

    @property
    def length_m(self) -> float:
        """From the middle of the machine to the farthest place along x where a foot may stand."""
        shaft = float(np.abs(self.legs.shaft_position[:, 0]).max())
        return shaft + self.linkage.crank + float(np.hypot(*self.linkage.foot))

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
        legs = read_legs(top.table("legs"))
        return LeggedMachine(
            mass_kg=read_body(top.table("body")).mass,
            legs=legs,
            linkage=read_linkage(top.table("linkage")),
            contact=read_contact(top.table("contact"), legs.count),
            effects=causes_of(read_effects(top, legs.names), legs.names),
        )
    except ConfigError as error:
        raise GapError(f"the robot file cannot be used: {error}") from error


def machine_of(trial: Trial) -> LeggedMachine:
    """Return the machine of a trial.

    Raises:
        GapError: There is no robot file beside it, or it cannot be used.
    """
    if not trial.header.robot_text:
        raise GapError(
            'the trial names no robot file; add robot = "FILE.toml" to [trial] in the file beside its table'
        )
    return parse_machine(trial.header.robot_text)
