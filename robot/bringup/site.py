"""Where a robot stands that is being brought up: real ports with a person at a terminal, or a virtual one.

What is opened here are wires, not drivers: a step may want to listen before anybody speaks.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from drivers.ati.links import DatagramLink, UdpLink
from drivers.wire.tap import TappedDatagrams, WireTap
from model.errors import ConfigError
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.person import Person, TerminalPerson
from robot.requests.single import VIRTUAL
from robot.run.force_unit import NO_UNIT, check_no_unit, wanted_unit
from robot.run.hardware import real_wires
from robot.run.rig import Wires


@dataclass(frozen=True, slots=True, kw_only=True)
class SiteRequest:
    """Which robot, and how it may be used.

    Attributes:
        hardware: Serial port of the servo bus, or ``virtual``.
        force_unit: Address of the force-torque unit, None for the robot file's, ``none`` for none.
        armed: Whether torque may be switched on; a virtual robot may always move.
        virtual_robot: Robot file of the virtual robot that is really there, None for the same file.
        scenario: Faults and assumptions of virtual devices.
        seed: Seed of their noise.
    """

    hardware: str = VIRTUAL
    force_unit: str | None = None
    armed: bool = False
    virtual_robot: Path | None = None
    scenario: Path | None = None
    seed: int = 0


def site_request(options: Any, **others: Any) -> SiteRequest:
    """Return the request in the options of a command that has some of its fields."""
    known = {
        name: getattr(options, name) for name in SiteRequest.__slots__ if hasattr(options, name)
    }
    return SiteRequest(**{**known, **others})


class Site(Protocol):
    """A robot within reach."""

    @property
    def name(self) -> str:
        """Port, or ``virtual``."""

    @property
    def virtual(self) -> bool:
        """Whether it is a virtual one, in virtual time."""

    @property
    def armed(self) -> bool:
        """Whether torque may be switched on."""

    def wires(self, tap: WireTap | None) -> Wires:
        """Return its wires, not open; without ``links`` where there is no force-torque unit."""

    def datagrams(self, tap: WireTap) -> DatagramLink | None:
        """Open the unit's data port without a word to the unit; None where there is none."""

    def person(self, *, yes: bool, ask: bool) -> Person:
        """Return whoever stands next to it.

        Args:
            yes: Whether to ask no question where nothing moves.
            ask: With a virtual robot: whether to put the questions to a person at the terminal.
        """


class RealSite:
    """Real ports.

    Args:
        request: Which.
        config: Robot file.
    """

    virtual = False

    def __init__(self, request: SiteRequest, config: RobotConfig) -> None:
        for option, value in (
            ("--virtual-robot", request.virtual_robot),
            ("--scenario", request.scenario),
        ):
            if value is not None:
                raise ConfigError(
                    option, "needs --hardware virtual; it is about virtual devices only"
                )
        self.name = request.hardware
        self.armed = request.armed
        self._config = config
        self._unit = wanted_unit(request.force_unit, config.force_sensor)

    def wires(self, tap: WireTap | None) -> Wires:
        """Return its wires."""
        return real_wires(self._config, self.name, self._unit, tap)

    def datagrams(self, tap: WireTap) -> DatagramLink | None:
        """Open the unit's data port."""
        unit = self._unit
        if unit is None:
            return None
        clock = self.wires(None).clock
        link = UdpLink(unit.address, unit.udp_port, unit.local_port, clock)
        return TappedDatagrams(link, tap, clock)

    def person(self, *, yes: bool, ask: bool) -> Person:
        """Return the person at the terminal."""
        del ask
        return TerminalPerson(yes=yes)


class VirtualSite:
    """A virtual robot hung in a frame, in virtual time.

    Args:
        request: Which.
        config: Robot file that the drivers use.
    """

    name = VIRTUAL
    virtual = True
    armed = True

    def __init__(self, request: SiteRequest, config: RobotConfig) -> None:
        from robot.virtual.hung import HungRobot
        from sim_hw.faults.scenario import load_scenario

        check_no_unit(request.force_unit)
        there = config if request.virtual_robot is None else load_robot(request.virtual_robot)
        if there.servo_bus.names != config.servo_bus.names:
            raise ConfigError(
                "--virtual-robot", "has other legs than the robot file; choose another"
            )
        scenario = None
        if request.scenario is not None:
            ids = [int(i) for i in there.servo_bus.ids]
            scenario = load_scenario(request.scenario, ids)
        self._legs = config.servo_bus.names
        self._without = request.force_unit == NO_UNIT
        self.robot = HungRobot(config, there, scenario, request.seed)

    def wires(self, tap: WireTap | None) -> Wires:
        """Return its wires."""
        return self.robot.wires(tap, with_forces=not self._without)

    def datagrams(self, tap: WireTap) -> DatagramLink | None:
        """Open the unit's data port."""
        links = self.wires(tap).links
        return None if links is None else links()[0]

    def person(self, *, yes: bool, ask: bool) -> Person:
        """Return the virtual person, or one at the terminal with the hands of the virtual one."""
        from robot.virtual.hung import VirtualPerson

        hands = VirtualPerson(self.robot, self._legs)
        return TerminalPerson(yes=yes, hands=hands) if ask else hands


def site_of(request: SiteRequest, config: RobotConfig) -> Site:
    """Return the robot that was asked for.

    Raises:
        ConfigError: The options do not fit together.
    """
    if request.hardware == VIRTUAL:
        return VirtualSite(request, config)
    return RealSite(request, config)
