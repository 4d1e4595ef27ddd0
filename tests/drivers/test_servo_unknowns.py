"""What the manual leaves open about a servo is found out by asking it, whichever way it is."""

import pytest

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.image import read_gains
from drivers.dynamixel.unknowns import NUDGE_TICKS, gains_at_mode_change, goal_at_torque_on
from model.errors import BusError
from robot.config.robot_file import load_robot
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.port import MemoryPort
from tests.sim_hw.faulty import BAUD, START_NS, FaultyBus


def servo_of(assumed: str) -> CheckedServo:
    """Return the third servo of a virtual bus, configured."""
    bus = FaultyBus(assumed, ids=(1, 2, 3, 4, 5, 6))
    servos = ServoBus(MemoryPort(bus.wire, VirtualClock(START_NS), BAUD), load_robot().servo_bus)
    servos.connect()
    servos.configure()
    return servos.servos()[2]


@pytest.mark.parametrize("assumed", ["kept", "here"])
def test_the_goal_that_torque_meets(assumed: str) -> None:
    servo = servo_of(f'[servo]\ngoal_at_torque_on = "{assumed}"')
    assert goal_at_torque_on(servo) == assumed
    assert servo.read("torque_enable") == 0


def test_it_hardly_moves() -> None:
    servo = servo_of('[servo]\ngoal_at_torque_on = "kept"')
    before = servo.read("present_position")
    goal_at_torque_on(servo)
    assert abs(servo.read("present_position") - before) <= NUDGE_TICKS


@pytest.mark.parametrize("assumed", ["kept", "reset"])
def test_gains_at_a_change_of_mode_and_afterwards_as_before(assumed: str) -> None:
    servo = servo_of(f'[servo]\ngains_at_mode_change = "{assumed}"')
    servo.write("position_p_gain", 640)
    before = read_gains(servo)
    assert gains_at_mode_change(servo) == assumed
    assert read_gains(servo) == before
    assert servo.read("operating_mode") == 4


def test_a_goal_that_becomes_something_else_is_an_error() -> None:
    class Wild(CheckedServo):
        """Turns its goal away when torque goes on."""

        def write_verified(self, name: str, value: int) -> None:
            CheckedServo.write_verified(self, name, value)
            if (name, value) == ("torque_enable", 1):
                goal = COMMON["goal_position"]
                self.packets.write(self.servo_id, goal.address, goal.encode(4000))

    servo = servo_of("")
    with pytest.raises(BusError, match=r"has goal_position 4000 .* do not walk"):
        goal_at_torque_on(Wild(servo.packets, servo.leg, servo.servo_id))
    assert servo.read("torque_enable") == 0
