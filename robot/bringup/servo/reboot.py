"""``bigant servo reboot``: reboot servos, and keep what they are about to forget."""

import sys
from dataclasses import asdict

from drivers.dynamixel.reboot import Reboot, reboot_servo
from drivers.dynamixel.registers import hardware_error_names
from robot.bringup.servo.access import confirmed, open_port, require_answers, scan_port, servo_at
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.requests.servo import ServoRebootRequest


def reboot(request: ServoRebootRequest) -> ExitCode:
    """Reboot one servo, or all that answer.

    Returns:
        OK, or VERDICT_FAILED when a servo still reports an error, or nothing was done.

    Raises:
        BusError: A servo does not answer, or does not come back.
    """
    config = load_robot(request.robot)
    baud = request.baud if request.baud is not None else config.servo_bus.baud_rate
    numbers = [request.id] if request.id is not None else _everybody(request.port, baud)
    with open_port(request.port, baud) as (port, packets):
        servos = [servo_at(port, packets, number, config) for number in numbers]
        holding = [f"{s.leg} (id {s.servo_id})" for s in servos if s.read("torque_enable")]
        if holding and not request.yes:
            print(f"torque is on: {', '.join(holding)}", file=sys.stderr)
            question = f"{', '.join(holding)} will drop what they carry; reboot?"
            if not confirmed(question, yes=False):
                return ExitCode.VERDICT_FAILED
        reboots = [reboot_servo(servo) for servo in servos]
    result = [
        {**asdict(one), "cause_names": one.cause_names, "turns_lost": one.turns_lost}
        for one in reboots
    ]
    print_result(result, map(line_of, reboots), as_json=request.json)
    well = all(one.error_after == 0 for one in reboots)
    return ExitCode.OK if well else ExitCode.VERDICT_FAILED


def _everybody(port: str, baud: int) -> list[int]:
    servos = require_answers(scan_port(port, baud), f"{port} at {baud} baud")
    return [servo.servo_id for servo in servos]


def line_of(reboot: Reboot) -> str:
    """Return one reboot as a line."""
    cause = ", ".join(reboot.cause_names) or "no hardware error"
    turns = reboot.turns_lost
    lost = f"{turns:+d} turns lost" if turns else "no turns lost"
    text = (
        f"{reboot.leg} (id {reboot.servo_id}): was {cause}; {lost} "
        f"({reboot.ticks_before} to {reboot.ticks_after} ticks); torque off; "
        f"back after {reboot.duration_s:.2f} s"
    )
    if reboot.error_after:
        names = ", ".join(hardware_error_names(reboot.error_after))
        text += f"; STILL REPORTS {names}: remove the cause"
    return text
