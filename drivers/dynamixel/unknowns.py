"""What the manual leaves open about a servo, found out by asking it: one servo, hung up, hardly moving."""

from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.image import GAINS, read_gains
from drivers.dynamixel.registers import OperatingMode

# The goal that torque meets: far enough from the shaft to be told from it, 0.7 degrees.
NUDGE_TICKS = 8


def goal_at_torque_on(servo: CheckedServo) -> str:
    """Switch torque on with a goal a little beside the shaft; off again afterwards.

    Args:
        servo: The servo, configured, torque off. The shaft turns by 0.7 degrees at most.

    Returns:
        ``kept`` if the goal stays as it was written, ``here`` if it becomes the position.

    Raises:
        BusError: It does not take a value, or its goal becomes something else.
    """
    servo.write_verified("bus_watchdog", 0)  # a tripped one takes no goal
    ticks = servo.read_run("present_velocity", "present_position")["present_position"]
    goal = ticks + NUDGE_TICKS
    servo.write("goal_position", goal)
    if _goal(servo) != goal:
        raise servo.error("did not keep its goal without torque: check its cable", "goal_position")
    try:
        servo.write_verified("torque_enable", 1)
        became = _goal(servo)
    finally:
        servo.write_verified("torque_enable", 0)
    if became == goal:
        return "kept"
    if abs(became - ticks) < NUDGE_TICKS // 2:
        return "here"
    raise servo.error(
        f"has goal_position {became} after torque went on at {ticks} with goal {goal}; do not walk",
        "goal_position",
    )


def gains_at_mode_change(servo: CheckedServo) -> str:
    """Change the operating mode to position and back, with a gain one above what it was.

    Args:
        servo: The servo in extended position mode, torque off. Its gains are put back; its turn counter
            may be set back.

    Returns:
        ``kept`` if the gain is as written, ``reset`` if it is not.

    Raises:
        BusError: It does not take a value.
    """
    before = read_gains(servo)
    odd = before[GAINS.index("position_p_gain")] + 1
    try:
        servo.write_verified("position_p_gain", odd)
        servo.write_verified("operating_mode", OperatingMode.POSITION)
        servo.write_verified("operating_mode", OperatingMode.EXTENDED_POSITION)
        return "kept" if servo.read("position_p_gain") == odd else "reset"
    finally:
        _put_back(servo, before)


def _put_back(servo: CheckedServo, gains: tuple[int, ...]) -> None:
    servo.ensure("operating_mode", OperatingMode.EXTENDED_POSITION)
    for name, value in zip(GAINS, gains, strict=True):
        servo.ensure(name, value)


def _goal(servo: CheckedServo) -> int:
    return servo.read_run("goal_position", "realtime_tick")["goal_position"]
