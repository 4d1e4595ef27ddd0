"""A virtual robot hung in a frame, and the person next to it: for the first day without a robot.

The devices stand in virtual time and keep their state from step to step. The robot that is really there may
differ from the robot file (ids, signs, zeros, transducers, yaw), so that a wrong robot file can be found.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.wire.tap import WireTap
from model.values.arrays import FloatArray
from robot.config.robot_file import RobotConfig
from robot.console.person import BACKWARD, FORWARD, NOTHING, Consent, Hand, Sight, Work
from robot.run.rig import Wires
from robot.virtual.file_twin import file_twin
from robot.virtual.open import VirtualSettings, memory_wires, new_clock
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.scenario import Scenario
from sim_hw.host.hung_world import Cable, HungWorld
from sim_hw.host.virtual_robot import VirtualRobot, build_virtual_robot, put_devices

PRESS_N = 12.0
# A hand presses a little aside, and not before it has read what to do.
SKEW = 0.06
REACTION_S = 0.5
PLUG_NS = 3_000_000_000
DIRECTIONS: dict[Hand, tuple[float, float, float]] = {
    Hand.PRESS_UP: (SKEW, 0.0, 1.0),
    Hand.PRESS_FORWARD: (1.0, SKEW, 0.0),
    Hand.PRESS_LEFT: (0.0, 1.0, SKEW),
}
# A shaft that turned less has not been seen to move.
SEEN_RAD = 0.02


class HungRobot:
    """The virtual robot of a first day.

    Args:
        config: Robot file that the drivers use.
        there: The robot that is really there.
        scenario: What is assumed about its devices and goes wrong with them; None for sound ones.
        seed: Seed of all noise.
    """

    def __init__(
        self, config: RobotConfig, there: RobotConfig, scenario: Scenario | None, seed: int
    ) -> None:
        self._config, self._there = config, there
        self._settings = VirtualSettings(seed=seed, scenario=scenario)
        self.clock = new_clock()
        firmware = FirmwareBank(len(there.servo_bus.ids))
        supply_v = there.parameters.servo.supply_voltage
        self.world = HungWorld(firmware, there.servo_bus, there.force_sensor, supply_v)
        devices = put_devices(
            self.world, firmware, there.servo_bus, there.force_sensor, seed, scenario
        )
        self.cable = Cable(devices.servo_wire)
        self.devices: VirtualRobot = replace(devices, servo_wire=self.cable)
        self._standing: VirtualRobot | None = None

    def put_down(self) -> None:
        """Put it on the floor, powered up again."""
        there, seed = self._there, self._settings.seed
        self._standing = build_virtual_robot(
            there.parameters, there.servo_bus, there.force_sensor, seed,
            file_twin(there, seed), self._settings.scenario,
        )  # fmt: skip

    def wires(self, tap: WireTap | None, *, with_forces: bool = True) -> Wires:
        """Return what the drivers are connected to, not open."""
        robot = self.devices if self._standing is None else self._standing
        settings = replace(self._settings, tap=tap, with_forces=with_forces)
        return memory_wires(self._config, robot, settings, self.clock)


class VirtualPerson:
    """``robot.console.person.Person`` beside a virtual robot: agrees to everything and never errs.

    Args:
        robot: The robot.
        legs: Leg names.
    """

    def __init__(self, robot: HungRobot, legs: Sequence[str]) -> None:
        self._robot = robot
        self._legs = list(legs)
        self._work: Work | None = None
        self._rest: FloatArray = robot.world.shaft_angle_rad
        self._seen: FloatArray = self._rest

    def allows(self, question: str, *, moves: bool) -> Consent:
        """Agree."""
        del question, moves
        return Consent.YES

    def does(self, work: Work) -> None:
        """Do it at once."""
        world = self._robot.world
        angle = np.full(len(self._legs), np.nan)
        match work.hand:
            case Hand.SET_MID_STANCE:
                world.turn_by_hand(np.zeros(len(self._legs)))
            case Hand.TURN_ONCE:
                leg = self._legs.index(work.leg)
                angle[leg] = world.shaft_angle_rad[leg] + 2 * np.pi
                world.turn_by_hand(angle)
            case Hand.PULL_CABLE:
                self._robot.cable.plugged = False
            case Hand.PLUG_CABLE:
                self._robot.clock.advance(PLUG_NS)
                self._robot.cable.plugged = True
            case Hand.LET_GO:
                world.press(0, np.zeros(3))
            case Hand.PUT_DOWN:
                self._robot.put_down()
            case Hand.WATCH:
                pass
            case _:
                world.press(self._legs.index(work.leg), PRESS_N * np.array(DIRECTIONS[work.hand]))

    def begins(self, work: Work) -> None:
        """Take note of what is to be done, and look on from here."""
        self._work = work
        self._rest = self._seen = self._robot.world.shaft_angle_rad

    def meanwhile(self, elapsed_s: float) -> None:
        """Do it after a moment; remember how far each leg was at most."""
        if self._work is not None and elapsed_s >= REACTION_S:
            self.does(self._work)
            self._work = None
        now = self._robot.world.shaft_angle_rad
        further = np.abs(now - self._rest) > np.abs(self._seen - self._rest)
        self._seen = np.where(further, now, self._seen)

    def sees(self, sight: Sight, question: str, choices: Sequence[str]) -> str:
        """Say which shaft truly turned, or which way."""
        del question
        turned = self._seen - self._rest
        leg = int(np.argmax(np.abs(turned)))
        if sight is Sight.WHICH_LEG:
            return self._legs[leg] if abs(turned[leg]) > SEEN_RAD else NOTHING
        # at the bottom of its path a foot moves backward while its shaft turns in the leg's sense
        answer = BACKWARD if turned[leg] > 0 else FORWARD
        return answer if answer in choices else choices[0]
